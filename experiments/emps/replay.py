"""The recorded loop on a simulated stage, beside what the real one did."""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.optimize import least_squares

from experiments.emps.logs import GAIN, K_P, SAMPLE, Floats, Log, following
from hfc_design.simulation.evaluating import evaluate

#: The loop that recorded the logs.
RECORDED = "emps-cascade"
PUBLISHED = {
    "mass": 95.11,
    "viscous_friction": 203.5,
    "viscous_asymmetry": 0.0,
    "coulomb_friction": 20.39,
    "offset": -3.16,
}
#: Those of the reference, but for starts and stops [mm/s].
SPEEDS = (42.1, 82.6, 124.7)


def replayed(one: Log, parameters: Mapping[str, float], pulse: float = 0.0) -> Floats:
    """Simulated less measured position (steps,) [mm]; the loop hears nothing of the log."""
    with TemporaryDirectory() as place:
        found = evaluate(RECORDED, following(one, Path(place), parameters, pulse))
    position = np.asarray(found.axes[0].motion.state.position)
    return position[one.earlier :] - one.position


def fitted(one: Log) -> dict[str, float]:
    """The parameters with which the loop is the least off a log, in squares."""
    names = [*PUBLISHED]
    start = np.array([95.0, 200.0, -0.2, 20.0, -0.5])

    def off(shares: Floats) -> Floats:
        return replayed(one, dict(zip(names, (start * shares).tolist(), strict=True)))[::5]

    found = least_squares(off, np.ones(len(names)), bounds=(-5.0, 5.0), diff_step=1e-2)
    return dict(zip(names, (start * found.x).tolist(), strict=True))


def rms(values: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def repeated(one: Log, off: Floats) -> float:
    """What is left of ``off`` [mm, rms] once the mean of its periods is taken away."""
    period = _period(one.reference)
    rows = off[: len(off) // period * period].reshape(-1, period)
    return rms(rows - rows.mean(axis=0))


def _period(reference: Floats) -> int:
    """Samples after which the reference comes again, to a micron."""
    first = reference[: len(reference) // 3]
    starts = range(1, len(reference) - len(first))
    return next(k for k in starts if rms(reference[k : k + len(first)] - first) < 1e-3)


def by_speed(one: Log, off: Floats) -> list[list[str]]:
    """Force that brakes the real stage more than the simulated one [N]; forwards, backwards.

    At a steady speed: as much as the loop commands for being so much further behind.
    """
    speed = np.gradient(one.position, SAMPLE)
    steady = np.abs(np.gradient(speed, SAMPLE)) < 50.0  # [mm/s2]
    rows = []
    for level in SPEEDS:
        near = steady & (np.abs(np.abs(speed) - level) < 3.0)
        each = [way * off[near & (np.sign(speed) == way)].mean() for way in (1.0, -1.0)]
        rows.append([f"{level:g} mm/s", *(f"{K_P * GAIN * x:+.2f}" for x in each)])
    return rows
