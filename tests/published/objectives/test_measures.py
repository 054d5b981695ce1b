"""Measures that add up while a loop runs, against NumPy on its recorded motion."""

import numpy as np
import pytest
import scipy.signal
from measuring import MOVE, measured, unsettled

from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.metrics import RUNNING, metric
from hfc_design.simulation.evaluating import evaluate

BAND = 1e-3


def by_hand(design, scenario):
    """The same of the recorded motion."""
    evaluation = evaluate(design, scenario)
    (axis,) = evaluation.axes
    error, command = axis.motion.error, axis.motion.command
    time, rate = evaluation.time, axis.happens.reference_rate
    settled = time >= load_scenario(scenario).fitness.settled_after_s
    late = np.arange(len(time)) >= 0.75 * len(time)
    fast = settled & (abs(rate) >= 0.5 * abs(rate).max()) & (abs(rate) > 0.0)
    mean = scipy.signal.lfilter([1 / 11], [1, -10 / 11], axis.velocity)  # a lag of 10 ms
    stands = abs(mean) < 0.1 * abs(rate)
    off = np.flatnonzero(abs(error) > BAND)
    position = axis.reference - error
    return {
        "rms_error": np.sqrt(np.mean(error**2)),
        "max_error": abs(error).max(),
        "settled_rms_error": np.sqrt(np.mean(error[settled] ** 2)),
        "settled_max_error": abs(error[settled]).max(),
        "iae": abs(error).sum() * 1e-3,
        "overshoot": max((position - axis.reference[-1]).max(), 0.0),
        "velocity_ripple": np.sqrt(np.mean(axis.motion.error_rate[settled] ** 2)),
        "chatter": np.sqrt(np.mean(np.diff(command, prepend=0.0) ** 2)),
        "peak_command": abs(command).max(),
        "rms_command": np.sqrt(np.mean(command**2)),
        "stick_slip": stands[fast].mean() if fast.any() else 0.0,
        "limit_share": (abs(command[late]) >= 9.0).mean(),
        "late_error": abs(error[late]).max(),
        "band_time": (off[-1] + 1) * 1e-3 if len(off) else 0.0,
    }


@pytest.mark.parametrize("design", ["lin-lee-1999-table-1", "pd-only"])
def test_measures_of_one_axis(design):
    expected = by_hand(design, MOVE)
    own = [metric(name, BAND) for name in expected]
    found = measured(design, MOVE, own)
    assert dict(zip(expected, found, strict=True)) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert expected["limit_share"] > 0.1  # there is something to see
    assert expected["overshoot"] > 0.01
    of_paths = {name for name, one in RUNNING.items() if one.path}
    assert {*RUNNING, "band_time"} == {*expected, *of_paths, "unsettled"}


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.0, 3.0])
def test_what_grows_is_seen_while_it_is_small(phase):
    """By e^(8 * 0.3) = 11 in a half: ten times; by e^(3 * 0.3) = 2.46: that many times."""
    for period in (0.02, 0.1, 0.3):
        alone = unsettled(0.0, period, phase)
        assert unsettled(8.0, period, phase, size=0.12, offset=0.5) > 0.3
        assert unsettled(3.0, period, phase) > 1.4 * alone
    assert unsettled(8.0, 0.0, size=0.13) > 0.3  # runs away without a swing


@pytest.mark.parametrize("phase", np.linspace(0.0, np.pi, 7))
def test_a_steady_swing_is_its_amplitude_however_slow(phase):
    """Its rms is 0.71 of the amplitude where a half holds it whole, and never more than 0.8."""
    assert unsettled(0.0, 0.3, phase, offset=5.0) == pytest.approx(np.sqrt(0.5), rel=0.03)
    for period in (0.25, 0.35, 0.4, 0.45, 0.5, 0.6, 0.8, 1.0, 2.0):  # the rate adds a little
        assert unsettled(0.0, period, phase, offset=5.0, size=0.1) < 0.08
    for period in (0.25, 0.4, 0.5):  # of a half that does not hold it whole
        assert unsettled(0.0, period, phase) > 0.4
