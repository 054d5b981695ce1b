"""Measures that add up while a loop runs, against NumPy on its recorded motion."""

import numpy as np
import pytest
from measuring import MOVE, measured, unsettled

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.motion.contour import (
    local_error,
)
from hfc_design.objectives.metrics import metric
from hfc_design.simulation.evaluating import evaluate

SPEEDS = "spindle_velocity", "rotor_velocity"
#: Half a turn within what other tests simulate of it too.
FAST = {"simulation.duration_s": 4.0, "reference.feed_mm_min": 2000.0}
BOTH = [metric("unsettled"), metric("stick_slip")]


@pytest.mark.parametrize("gain", [1.0, 2.0])
def test_what_a_disturbance_of_the_start_leaves_is_that_of_two_motions(gain):
    """Of one that settles, and of one beyond the limit of its gain."""
    design = load_design("pd-only", [f"controller.pd.k{x}={750 * gain}" for x in "pd"])
    off = 0.01 * 0.02  # a hundredth of the way of the move
    begun = {"rotor_angle": off, "spindle_angle": off}
    one, other = (evaluate(design, MOVE | {"start": start}).axes[0] for start in ({}, begun))

    def apart(*names):
        """By half of the last quarter; the spindle counts in full, the rotor half."""
        parts = [
            share * (getattr(other.motion.state, x) - getattr(one.motion.state, x)) / off
            for share, x in zip((1.0, 0.5), names, strict=True)
        ]
        return sum(parts)[-500:].reshape(2, 250)

    place, speed = apart("spindle_angle", "rotor_angle"), apart(*SPEEDS)
    swing = np.hypot(place.std(axis=1), 0.01 * speed.std(axis=1))  # ten samples are 10 ms
    growth = min(x.std(axis=1)[1] / x.std(axis=1)[0] for x in (place, speed))
    expected = swing[1] * np.clip(growth, 1.0, 10.0)
    found, _ = measured(design, MOVE, BOTH)
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.0, 3.0])
def test_what_decays_counts_by_what_is_left_of_it(phase):
    """At e^(-3 t) the last half begins with 2.46 and ends with 1."""
    for period in (0.2, 0.3, 0.4, 0.5):
        assert 0.6 < unsettled(-3.0, period, phase) < 1.4
        assert unsettled(-3.0, period, phase, size=0.1) < 0.14


def test_contour_error_and_vectors_of_two_axes():
    """A circle: the errors of the page's metrics, which are read off the recorded motion."""
    circle = load_scenario("feed-drive-circle", FAST)
    names = (
        "estimated_rms_contour_error",
        "estimated_max_contour_error",
        "rms_error",
        "peak_command",
    )
    names += ("estimated_path_error", "estimated_worst_glitch")
    found = measured("jee-koren-2004-pid", circle, [metric(x) for x in names])
    rms, most, vector, peak, quiet, glitch = found
    evaluation = evaluate("jee-koren-2004-pid", circle)
    x, y = (axis.motion for axis in evaluation.axes)
    assert vector == pytest.approx(np.sqrt(np.mean(x.error**2 + y.error**2)))
    assert peak == max(abs(x.command).max(), abs(y.command).max())
    off = evaluation.contour.error
    # The measure linearises about where the machine should be, the page finds the nearest point.
    assert rms == pytest.approx(np.sqrt(np.mean(off**2)), rel=1e-3)
    assert most == pytest.approx(abs(off).max(), rel=1e-3)
    assert quiet == pytest.approx(evaluation.metrics["path_error_BLU"], rel=1e-3)
    assert glitch == pytest.approx(evaluation.metrics["worst_glitch_BLU"], rel=1e-3)
    assert 0.0 < quiet < glitch


def test_nothing_counts_where_nothing_slides():
    still = MOVE | {"reference": {"kind": "step", "height": 0.001}}
    assert measured("pd-only", still, BOTH)[1] == 0.0


def test_local_error_of_traced_scalars():
    jax = pytest.importorskip("jax")
    values = (0.3, -0.2, 0.6, 0.8, 0.05)
    traced = jax.jit(jax.vmap(local_error))(*np.array(values)[:, None])
    assert float(traced[0]) == pytest.approx(local_error(*values), rel=1e-6)
