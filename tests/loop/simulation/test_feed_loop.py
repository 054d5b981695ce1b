"""X-Y machines in the population simulator: contour metrics and fitness, bad input."""

import numpy as np
import pytest
from wording import refused

from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate, notes

CIRCLE = "feed-drive-circle"


@pytest.fixture(scope="module")
def flc():
    """An eighth of the circle."""
    design = load_design("jee-koren-2004-flc")
    return evaluate(design, own_scenario(design, design.name, ["simulation.duration_s=5"]))


def test_contour_metrics_and_fitness_are_those_of_the_radius(flc):
    x, y = (axis.motion.state.position for axis in flc.axes)
    radius = np.hypot(x + 4000.0, y)  # the circle starts at (R, 0)
    rms, worst = np.sqrt(((radius - 4000.0) ** 2).mean()), abs(radius - 4000.0).max()
    assert flc.metrics["rms_contour_error_BLU"] == pytest.approx(rms, rel=1e-9)
    assert flc.metrics["max_contour_error_BLU"] == pytest.approx(worst, rel=1e-9)
    # The lag: how far the machine is behind in the direction in which the circle goes on.
    angle = 754 / 60 / 40 * flc.time
    away = np.stack([x + 4000.0, y]) - 4000.0 * np.stack([np.cos(angle), np.sin(angle)])
    lag = (away * np.stack([-np.sin(angle), np.cos(angle)])).sum(axis=0)
    whole = rms + 0.3 * worst + 0.01 * np.sqrt((lag**2).mean())
    assert flc.fitness == pytest.approx(1 / whole, rel=1e-6)


def test_commands_and_readings_are_whole_numbers(flc):
    for axis in flc.axes:
        command = axis.motion.command
        assert (command == np.round(command)).all()
        assert (axis.reference == np.round(axis.reference)).all()
        assert abs(command).max() <= 32  # the table's largest singleton


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ("reference.feed_mm_min=99999.0", "reference"),
        ("reference={kind='ramp'}", "reference.kind"),
        ("plant.axes={}", "reference.kind"),
        ("plant.axes.x.gain=-1.0", "plant.axes.x"),
        ("fitness.kind='best'", "fitness"),
    ],
)
def test_machines_that_cannot_follow_are_refused(change, where):
    with refused() as found:
        load_scenario(CIRCLE, [change])
    assert found.refusal.startswith(f"{CIRCLE}: {where}")


def test_a_path_that_the_simulation_cuts_short_is_told():
    """60 s of a circle: said of 10 s, not of all of it."""
    whole, part = (load_scenario(CIRCLE, {"simulation.duration_s": x}) for x in (60.0, 10.0))
    assert notes(whole, {}) == []
    assert "ends after 10 s of a path of 60 s" in notes(part, {})[0]
