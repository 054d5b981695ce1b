"""X-Y machines in the population simulator: contour metrics and fitness, bad input."""

import numpy as np
import oracle
import pytest
from populations import HIERARCHICAL, LOADS, plain, simulated
from wording import refused

import hfc_design.api as hfc
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


@pytest.mark.parametrize("scenario", LOADS)
def test_loop_is_plain_rk4_to_rounding(scenario, random_population):
    gains = random_population(8, seed=6)
    states, motion = simulated(scenario, HIERARCHICAL, gains)
    for one in range(8):
        exact, commands = oracle.closed_loop(*plain(gains, one), 1.0, LOADS[scenario], "RK4")
        error = abs(states[..., one] - exact) / abs(exact).max(axis=0)
        assert error.max() < 1e-8
        assert abs(motion.command[:-1, one] - commands).max() < 1e-7


def by_error(axis, field):
    step = {"position": 0.005, "motor_position": 0.00125}[field]
    return axis.reference - step * np.round(getattr(axis.motion.state, field) / step)


def by_hand(axis, field):
    """Commands of the PID that sees a state field in steps of 5 or 1.25 um."""
    errors = by_error(axis, field)
    rate = np.diff(errors, prepend=0.0) / 0.005
    return 28.0 * errors + 85.0 * 0.005 * np.cumsum(errors) + 0.1 * rate


def test_each_axis_is_told_of_the_encoder_that_is_named():
    changes = {"simulation.duration_s": 2.5, "sensors.axes.y.feedback": "motor_position"}
    found = hfc.evaluate("huang-pid", hfc.load_scenario("milling-table-circle", changes))
    own = dict(zip(("position", "motor_position"), found.axes, strict=True))
    for field, axis in own.items():
        np.testing.assert_allclose(axis.motion.command, by_hand(axis, field), atol=1e-9)
        np.testing.assert_allclose(axis.sensed()["error"], by_error(axis, field), atol=1e-12)
        # What is judged is where the table is, whoever knows it.
        true = axis.happens.target - axis.motion.state.position
        np.testing.assert_allclose(axis.motion.error, true, atol=1e-12)
    # The contour error is the distance from the centre less the radius, of the tables and as the
    # control knows it.
    for key, seen in (("", ("position",) * 2), ("known_", own)):
        x, y = (getattr(a.motion.state, f) for a, f in zip(found.axes, seen, strict=True))
        off = np.hypot(x + 60.0, y) - 60.0
        assert found.metrics[f"{key}max_contour_error_mm"] == pytest.approx(np.abs(off).max())
        rms = np.sqrt(np.mean(off**2))
        assert found.metrics[f"{key}rms_contour_error_mm"] == pytest.approx(rms)
    known = found.metrics["known_rms_contour_error_mm"]
    assert found.metrics["rms_contour_error_mm"] != pytest.approx(known, rel=0.1)


@pytest.mark.parametrize(
    ("scenario", "encoder"), [("milling-table-circle", "velocity"), ("c-axis-ramp", "current")]
)
def test_an_unknown_encoder_is_one_line(scenario, encoder):
    with refused() as found:
        hfc.load_scenario(scenario, {"sensors.feedback": encoder})
    assert found.refusal.startswith(f"{scenario}: sensors.feedback = ")
