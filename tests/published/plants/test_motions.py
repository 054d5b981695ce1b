"""The positioning stage in its recorded loop, and friction of fast spindles, against Radau."""

import jax
import jax.numpy as jnp
import numpy as np
import oracle
import pytest

import hfc_design.api as hfc
from plants.c_axis import CAxisParameters, CAxisState, coefficients, step


def test_the_recorded_loop_follows_as_far_behind_as_by_hand():
    """u = k_v (k_p e - v) holds a speed where u g = F_c + offset + F_v v."""
    motion = hfc.evaluate("emps-cascade", "positioning-stage-move").axes[0].motion
    assert motion.state.velocity[1500] == pytest.approx(125.0, rel=2e-4)
    voltage = (20.39 - 3.16 + 203.5 * 0.125) / 35.1507
    assert motion.command[1500] == pytest.approx(
        voltage, abs=0.06
    )  # a step of the encoder: 0.039 V
    wanted = (voltage / 243.45 + 0.125) / 160.18  # [m]
    assert motion.error[1000:2000].mean() == pytest.approx(1e3 * wanted, abs=2e-4)
    assert motion.error[-1] == pytest.approx(0.0, abs=0.02)  # friction holds it against the loop
    assert motion.state.velocity[-1] == 0.0


GAINS = (758.405, 743.010)  # of the PD part of Table I
PERIOD = 1e-3


def ramp(speed):
    return lambda t: (speed * t, speed)


def reversals(speed, period=0.2):
    rate = 2 * np.pi / period
    return lambda t: (speed / rate * (1 - np.cos(rate * t)), speed * np.sin(rate * t))


def stop(speed, period=0.2):
    """From rest to rest."""
    rate = 2 * np.pi / period

    def reference(t):
        t = min(t, period)
        return 0.5 * speed * (t - np.sin(rate * t) / rate), 0.5 * speed * (1 - np.cos(rate * t))

    return reference


def angles(reference, samples, dtype, **machine):
    """(samples,) spindle angle [rad] at the end of each, under the PD gains, from rest."""
    with jax.enable_x64(True):
        fixed = jax.tree.map(dtype, coefficients(CAxisParameters(**machine)))
        kp, kd = map(dtype, GAINS)

        def sample(x, told):
            place, rate = told
            voltage = kp * (place - x.spindle_angle) + kd * (rate - x.spindle_velocity)
            new = step(fixed, x, voltage, (dtype(0),) * 3, dtype(PERIOD))
            return new, new.spindle_angle

        told = np.array([reference(n * PERIOD) for n in range(samples)], dtype)
        start = CAxisState(*jnp.zeros(6, dtype))
        return np.asarray(jax.lax.scan(sample, start, tuple(told.T))[1], float)


@pytest.mark.parametrize(
    ("reference", "bound"),  # [rad]; about twice what is measured
    [
        *((ramp(speed), 2e-10) for speed in (0.002, 0.02, 0.05, 0.1)),
        *((ramp(speed), 2e-9) for speed in (0.2, 0.5, 1.1)),
        (reversals(0.05), 6e-8),
        (reversals(0.5), 3e-6),
        (reversals(1.1), 3e-6),
        (stop(0.05), 1e-7),
        (stop(0.5), 5e-7),
        (stop(1.1), 1e-6),
    ],
)
def test_one_step_a_millisecond_follows_radau(reference, bound):
    exact = oracle.closed_loop(None, *GAINS, 0.3, method="Radau", reference=reference)[0][1:, 3]
    assert abs(angles(reference, 300, np.float64) - exact).max() < bound
    # An angle of 0.3 rad is a multiple of 3e-8 in float32.
    assert abs(angles(reference, 300, np.float32) - exact).max() < bound + 5e-7
