"""What stands around a drive, beside exact solutions and SciPy's."""

from itertools import pairwise
from typing import Any

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plants import machine_of
from plants.around import Around, Standing, sampled, surrounded
from plants.positioning_stage import POSITIONING_STAGE as STAGE

PERIOD, GAIN, DRAG, MASS = 1e-3, 35.0, 200.0, 90.0
PARAMETERS = STAGE.parameters(
    mass=MASS, viscous_friction=DRAG, coulomb_friction=0.0, offset=0.0, amplifier_gain=GAIN
)
COMMANDS = np.random.default_rng(3).uniform(-5.0, 5.0, 40)


def driven(
    around: Around, substeps: int = 1, waits: int = 0, own: Any = PARAMETERS
) -> tuple[Any, Any]:
    """States after each of ``COMMANDS`` as (samples,) columns, and what is measured then."""
    (drive,) = surrounded(machine_of(STAGE), waits, substeps).drives
    with jax.enable_x64(True):
        fixed = drive.coefficients(Standing(own, sampled(around, PERIOD, substeps, waits)))
        dt = PERIOD / substeps

        @jax.jit
        def one(state: Any, command: Any) -> Any:
            step = lambda _, x: drive.step(fixed, x, command, (0.0, 0.0, 0.0), dt)  # noqa: E731
            state = jax.lax.fori_loop(0, substeps, step, state)
            return state, (state, drive.measured(fixed, state))

        begun = jax.tree.map(lambda x: x + 0.0, drive.initial_state(jax.numpy.zeros(())))
        found = jax.lax.scan(one, begun, jax.numpy.asarray(COMMANDS))[1]
        return jax.tree.map(np.asarray, found)


def pushed(force: Any, breaks: Any, more: Any = None, size: int = 2) -> Any:
    """(samples, size) states of the stage in m under ``force(t, x)`` in V, by SciPy.

    ``more(t, x)`` are the rates of further states; ``breaks`` where the force jumps.
    """
    end = PERIOD * len(COMMANDS)
    edges = np.unique(np.clip([0.0, *breaks, *PERIOD * np.arange(len(COMMANDS) + 1)], 0.0, end))
    x, found = np.zeros(size), {}
    for a, b in pairwise(edges):
        at = 0.5 * (a + b)

        def rates(t: float, x: Any, at: float = at) -> Any:
            u = force(at, x)
            own = [x[1], (GAIN * u - DRAG * x[1]) / MASS]
            return [*own, *(more(at, x) if more else [])]

        if b - a > 1e-12:
            x = solve_ivp(rates, (a, b), x, method="DOP853", rtol=1e-11, atol=1e-14).y[:, -1]
        found[round(b / PERIOD, 6)] = x
    return np.array([found[float(k)] for k in range(1, len(COMMANDS) + 1)])


def at(t: float) -> float:
    """The command at a time, 0 before the first."""
    k = int(np.floor(t / PERIOD + 1e-9))
    return float(COMMANDS[k]) if k >= 0 else 0.0


@pytest.mark.parametrize(("delay", "waits"), [(1.6, 2), (0.35, 1), (2.0, 4)])
def test_a_command_acts_later_by_whole_samples_and_parts(delay, waits):
    edges = PERIOD * (np.arange(len(COMMANDS)) + delay)
    exact = pushed(lambda t, x: at(t - delay * PERIOD), edges)
    found, _ = driven(Around(delay_samples=delay), 20, waits)
    np.testing.assert_allclose(found.velocity, 1e3 * exact[:, 1], atol=1e-9)
    np.testing.assert_allclose(found.position, 1e3 * exact[:, 0], atol=1e-9)
    once, _ = driven(Around(delay_samples=delay), 1, waits)  # in the mean over a sample
    np.testing.assert_allclose(once.velocity, found.velocity, atol=5e-3)
    np.testing.assert_allclose(once.velocity[-1], found.velocity[-1], atol=2e-3)


def test_a_current_follows_its_command_with_a_lag():
    lag = 0.7e-3
    exact = pushed(lambda t, x: x[2], (), lambda t, x: [(at(t) - x[2]) / lag], 3)
    found, _ = driven(Around(lag_s=lag))
    np.testing.assert_allclose(found.lagged, exact[:, 2], atol=1e-9)
    np.testing.assert_allclose(found.velocity, 1e3 * exact[:, 1], atol=0.02)
    finer, _ = driven(Around(lag_s=lag), 20)
    np.testing.assert_allclose(finer.velocity, 1e3 * exact[:, 1], atol=5e-5)


@pytest.mark.parametrize("far", [False, True])
def test_a_mode_is_that_of_two_masses(far):
    """A mass on a spring and a damper beside the one that is pushed, which SciPy moves."""
    part, hz, damping = (1.0 / 3.0, 60.0, 0.02)
    other, own = part * MASS, (1.0 - part) * MASS
    w, reduced = 2.0 * np.pi * hz, own * other / MASS
    stiff, damper = reduced * w**2, 2.0 * damping * w * reduced

    def rates(t: float, x: Any) -> Any:  # without drag: it has the mode's force alone
        between = stiff * (x[0] - x[2]) + damper * (x[1] - x[3])
        return [x[1], (GAIN * at(t) - between) / own, x[3], between / other]

    x, exact = np.zeros(4), []
    for k in range(len(COMMANDS)):
        middle = (k + 0.5) * PERIOD
        ends = (0.0, PERIOD)
        x = solve_ivp(
            lambda t, x, m=middle: rates(m, x), ends, x, "DOP853", rtol=1e-11, atol=1e-14
        ).y[:, -1]
        exact.append(x[3] if far else x[1])
    share = -1.0 if far else part / (1.0 - part)
    free = PARAMETERS._replace(viscous_friction=1e-6)
    found, _ = driven(Around(mode_hz=hz, mode_damping=damping, mode_share=share), own=free)
    np.testing.assert_allclose(found.velocity, 1e3 * np.array(exact), atol=2e-6)


def test_the_reading_stays_within_a_gap_of_the_axis():
    gap = 2e-3
    found, read = driven(Around(backlash=gap))
    place, shown = 0.0, 0.0
    for now, told in zip(found.position, read.position, strict=True):
        place, shown = now, np.clip(shown, now - 0.5 * gap, now + 0.5 * gap)
        assert told == pytest.approx(shown, abs=1e-12)
    assert np.ptp(found.position) > gap > np.abs(place - shown) > 0.0


def test_jitter_changes_every_sample_and_not_their_sum():
    found, _ = driven(Around(jitter=0.1))
    plain, _ = driven(Around())
    steps = (
        np.diff(found.position, prepend=0.0) / found.velocity
        - np.diff(plain.position, prepend=0.0) / plain.velocity
    )
    assert np.abs(steps).max() > 0.02 * PERIOD
    assert abs(found.velocity[-1] - plain.velocity[-1]) < 0.1 * np.abs(plain.velocity).max()


def test_a_load_is_added_and_nothing_around_changes_nothing():
    bare, _ = driven(Around())
    exact = pushed(lambda t, x: at(t), ())
    np.testing.assert_allclose(bare.velocity, 1e3 * exact[:, 1], atol=1e-9)
    found, _ = driven(Around(load=7.0))
    late = (1.0 - np.exp(-DRAG / MASS * PERIOD * len(COMMANDS))) * 7.0 / DRAG
    assert found.velocity[-1] - bare.velocity[-1] == pytest.approx(-1e3 * late, rel=1e-9)
