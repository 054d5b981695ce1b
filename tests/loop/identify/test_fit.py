"""What is found in logs of a cart, against least squares by NumPy and SciPy on its closed form."""

import jax
import numpy as np
import pytest
from carts import CART, Cart, driven, forced, recorded

from hfc_design.identify.fit import Problem, fitted, settled
from hfc_design.identify.free import free
from hfc_design.identify.replay import replay
from hfc_design.identify.search import Found

TRUE = Cart(mass=2.6, viscous_friction=6.0, force_gain=1.3, pull=-0.4)
STEPS = 800


def found(names, place, force, bandwidth=0.0, late=True):
    """The fit by one start, that of a machine with twice the mass say."""
    changes = {n: x for n, x in TRUE._asdict().items() if n not in names}
    wanted = free(CART, changes, names)
    residual = replay(wanted, recorded(place, force), bandwidth, 1)
    held = np.append(np.ones(len(names)), float(late))
    problem = Problem(wanted, residual, np.array([np.std(place)]), held)
    with jax.enable_x64(True):
        problem, numbers = settled(problem, wanted.begun)
        return Found(fitted(problem, numbers, 1), problem, bandwidth)


@pytest.mark.parametrize("bandwidth", [0.0, 5.0])
def test_a_delay_of_two_samples_is_found(bandwidth):
    force = forced(STEPS)
    late = driven(TRUE, np.r_[force[0], force[0], force[:-2]])
    one = found(["mass", "viscous_friction"], late, force, bandwidth)
    np.testing.assert_allclose(one.fit.free.values(one.fit.numbers), [2.6, 6.0], rtol=1e-3)
    assert one.fit.late == pytest.approx(2.0, abs=0.01)
