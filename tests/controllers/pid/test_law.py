"""The PID controller: by hand, and its poles against numpy's roots."""

import numpy as np
import pytest

from hfc_design.controllers.pid.law import PidGains, damped_poles, pid, pid_by_pole_placement
from hfc_design.core.scalars import SCALARS


def test_law_by_hand():
    law = pid(0.01)
    memory = law.initial_memory(0.0)
    gains = PidGains(1.5, 8.1, 0.1)
    first, memory = law.step(SCALARS, gains, memory, {"error": 2.0})
    assert first == pytest.approx(1.5 * 2 + 8.1 * 0.01 * 2 + 0.1 * 2 / 0.01)
    second, _ = law.step(SCALARS, gains, memory, {"error": 1.0})
    assert second == pytest.approx(1.5 * 1 + 8.1 * 0.01 * 3 - 0.1 * 1 / 0.01)


@pytest.mark.parametrize(
    "poles",
    [
        (-10.0, -20.0, -30.0),
        (-5 + 5j, -5 - 5j, -60.0),
        damped_poles(0.7, 12.0, 55.0),
        damped_poles(1.3, 8.0, 40.0),
    ],
)
def test_poles_are_where_they_were_asked_for(poles):
    gain, tau = 28.3, 0.055
    k_p, k_i, k_d = pid_by_pole_placement(gain, tau, poles)
    found = np.roots([tau, 1.0 + gain * k_d, gain * k_p, gain * k_i])
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(poles), rtol=1e-9)


def test_gains_of_jk04_come_back_from_their_poles():
    gain, tau = 28.3, 0.055
    poles = np.roots([tau, 1.0 + gain * 0.1, gain * 1.5, gain * 8.1])
    assert pid_by_pole_placement(gain, tau, poles) == pytest.approx((1.5, 8.1, 0.1))


def test_damped_poles():
    slow, other, fast = damped_poles(0.5, 10.0, 80.0)
    assert abs(slow) == pytest.approx(10.0)
    assert slow.real == pytest.approx(-5.0)
    assert other == slow.conjugate()
    assert fast == -80.0


@pytest.mark.parametrize("poles", [(-1.0, -2.0), (-1 + 1j, -2.0, -3.0)])
def test_poles_that_no_gains_give(poles):
    with pytest.raises(ValueError, match="pole"):
        pid_by_pole_placement(28.3, 0.055, poles)
