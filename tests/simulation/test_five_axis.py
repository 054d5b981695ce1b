"""Five axes through a program in the closed loop: what PID control does by hand, and bad input."""

import numpy as np
import pytest

import hfc_design.api as hfc
from hfc_design.files.pairing import load_design

PID = "lin-gai-2009-pid"
LIMIT = "{velocity_per_min = 30000, acceleration_per_s2 = 800.0}"


@pytest.fixture
def scenario(tmp_path):
    """Made of a program, on five axes that start at 0."""

    def made(text, *changes, name="part.ngc"):
        (tmp_path / name).write_text(text)
        reference = {"kind": "gcode", "file": str(tmp_path / name)}
        limits = {axis: {"acceleration_per_s2": 800.0} for axis in "xyzac"}
        data = {
            "plant": {"name": "five-axis"},
            "reference": reference | {"limits": limits},
            "simulation": {"duration_s": 1.0, "sample_time_s": 0.002},
            "limits": {"command": 8.0},
            "controller": {"kind": "pid"},
        }
        return hfc.load_scenario(data, list(changes))

    return made


def test_following_errors_are_those_of_the_gain(scenario):
    """At constant speed (v + what friction and damping cost) / 33.33; k_i adds less than 1 %."""
    found = hfc.evaluate(PID, scenario("G1 X50 Y20 A40 F3600"))
    at = np.searchsorted(found.time, 0.7)
    share = 60.0 / np.hypot(50.0, 20.0)
    for k, rate in ((0, 50 * share), (1, 20 * share), (3, 40 * share)):
        axis = found.axes[k]
        p, unit = axis.parameters, np.pi / 180.0 if k == 3 else 1e-3
        lost = (p.coulomb_friction + p.viscous_friction * rate * unit) / p.amplifier_gain / unit
        assert axis.happens.reference_rate[at] == pytest.approx(rate)
        assert axis.motion.error[at] == pytest.approx((rate + lost) / 33.33, rel=0.01)
    # with equal gains the errors lie along the path, but for what friction costs each axis
    assert found.metrics["max_contour_error_mm"] < 0.06
    assert found.metrics["x_max_error_mm"] > 1.6


def test_the_published_program_at_rest_limits_and_ends():
    found = hfc.evaluate(PID, "five-axis-program")
    for axis, (start, end) in {"x": (-1.0, -0.648), "z": (-150.0, -171.732)}.items():
        own = found.axes["xyzac".index(axis)]
        assert own.motion.state.position[0] == start
        assert own.reference[-1] == pytest.approx(end)
        assert own.motion.state.position[-1] == pytest.approx(end, abs=0.08)
    for axis in "xyzac":
        unit = "deg" if axis in "ac" else "mm"
        assert found.metrics[f"{axis}_overshoot_{unit}"] == 0.0
    assert found.metrics["limit_share"] == 0.0
    assert found.metrics["velocity_share"] < 1.0
    header = hfc.trajectory_csv(found).split("\n")[0]
    assert "z_voltage_V,a_reference_deg,a_position_deg,a_error_deg" in header
    printed = hfc.evaluate(PID, "five-axis-program-printed")
    assert printed.metrics["c_max_error_deg"] > 3 * found.metrics["c_max_error_deg"]


@pytest.mark.slow
def test_gravity_and_unbalance_are_felt_where_axes_are_coupled():
    """Z sags by no more than 30 kg over 7e4 N s/m over 33.33 1/s, and what friction adds."""
    alone = load_design(PID)
    together = load_design(PID, {"plant.name": "five-axis-coupled"})
    where = hfc.load_scenario("five-axis-program", {"plant.name": "five-axis-coupled"})
    free = hfc.evaluate(alone, "five-axis-program").axes[2].motion.error
    found = hfc.evaluate(together, where).axes[2].motion.error
    sag = 1e3 * 30 * 9.81 / 7e4 / 33.33
    assert found[40:300] - free[40:300] == pytest.approx(sag, rel=0.2)


@pytest.mark.slow
def test_a_population_does_what_one_machine_does():
    """In float32, and by the fitness of the contour, of which the tables' orientation is a part."""
    found = hfc.evaluate(PID, "five-axis-program")
    spread = hfc.robustness(PID, "five-axis-program", spread=0.3, samples=12)
    assert spread.stable.all()
    assert spread.nominal["rms_contour_error_mm"] == found.metrics["rms_contour_error_mm"]
    values = spread.values["rms_contour_error_mm"]
    assert (
        0.5
        < values.min() / found.metrics["rms_contour_error_mm"]
        < 1.0
        < values.max() / values.min()
    )


def test_an_x_y_machine_may_have_limits_of_each_axis():
    """The same program, a little slower or faster; and its contour by either way of measuring."""
    known = {"simulation.duration_s": 40.0}
    axes = "{acceleration_per_s2 = 100.0, velocity_per_min = 3000}"
    limits = [f"reference.limits.{axis}={axes}" for axis in "xy"]
    file = str(hfc.load_scenario("feed-drive-contour").reference.file)
    own = [f"reference={{kind='gcode', file='{file}'}}", *limits, "simulation.duration_s=40.0"]
    found = hfc.evaluate("jee-koren-2004-pid", hfc.load_scenario("feed-drive-contour", own))
    before = hfc.evaluate("jee-koren-2004-pid", hfc.load_scenario("feed-drive-contour", known))
    ratio = found.metrics["rms_contour_error_BLU"] / before.metrics["rms_contour_error_BLU"]
    assert 0.5 < ratio < 2.0


@pytest.mark.parametrize(
    ("text", "changes", "message"),
    [
        ("G1 X5 F60\nX700", ["reference.limits.x.travel=[-10,600]"],
         "part.ngc: line 2: X goes to 700, outside its travel of -10 to 600 mm"),
        ("F600\nG3 X20 I10 A5", ["reference.limits.y.travel=[-2,50]"],
         "part.ngc: line 2: Y goes to -10, outside its travel of -2 to 50 mm"),
        ("G1 X5 F60\nB5", [], "part.ngc: line 2: moves B; the machine has no such axis, only x, y"),
        ("G1 X5 F0", [], "line 1: F0: a feed has to be more than 0 mm/min"),
        ("F60 G2 X5", [], "line 1: an arc without a centre: neither I, J nor R, or all are 0"),
        ("G1 X5", [], "line 1: G1 before any F"),
        ("G93 G1 X5 A3", [], "line 1: G1 without an F of its own, which G93 asks for"),
        ("M30", [], "part.ngc: has no motion in x, y, z, a, c"),
        ("G0 X400", ["reference.limits.x.velocity_per_min=45000"],
         "reference: line 1: asks the X axis for 33941 mm/min, but its drive reaches 29727 mm/min; "
         "set limits.x.velocity_per_min"),
        ("G1 X5 F60", ["reference.limits.b.acceleration_per_s2=5"],
         "reference.limits.b: the machine has no such axis; it has x, y, z, a, c"),
        ("G1 X5 F60", ["reference.start={w = 1.0}"], "reference.start.w: the machine has no such"),
        ("G1 X5 F60", ["reference.limits.x.acceleration_time_s=0.4"],
         "reference.limits.x.needs either acceleration_per_s2 or acceleration_time_s"),
        ("G1 X5 F60", ["reference.limits.x.rapid_per_min=3e4",
                       "reference.limits.x.velocity_per_min=2e4"],
         "rapid_per_min = 30000.0: is more than velocity_per_min = 20000.0"),
        ("G1 X5 F60", ["reference.acceleration_mm_s2=50"],
         "reference.acceleration_mm_s2: has no meaning beside limits"),
    ],
)  # fmt: skip
def test_bad_programs_are_one_clear_line(scenario, text, changes, message):
    with pytest.raises(hfc.UserError) as caught:
        scenario(text, *changes)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        ("{kind = 'gcode', file = 'part.ngc'}", "reference.limits.x: is missing"),
        ("{kind = 'circle', radius_mm = 5.0, feed_mm_min = 600.0}",
         "a machine of 5 axes follows a program, or kind 'per-axis'"),
        ("{kind = 'gcode', file = 'part.ngc', start = {x = 1.0}}", "start: needs limits"),
    ],
)  # fmt: skip
def test_references_that_five_axes_cannot_follow(
    scenario, tmp_path, monkeypatch, reference, message
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.ngc").write_text("G1 X5 F60")
    with pytest.raises(hfc.UserError, match=message):
        hfc.load_scenario("five-axis-program", [f"reference={reference}"])


def test_a_circle_of_one_table_says_how_to_get_two_axes():
    with pytest.raises(hfc.UserError, match=r"with \[plant.axes.x\] and \[plant.axes.y\]"):
        hfc.load_scenario("milling-table-circle", ["plant={name='milling-table'}"])


def test_what_a_reference_lacks_is_told_at_once():
    with pytest.raises(hfc.UserError) as caught:
        hfc.load_scenario("milling-table-circle", ["reference={kind='circle', radius=5}"])
    first, second = str(caught.value).split("\n")
    assert first.endswith("reference.radius_mm, reference.feed_mm_min: are missing")
    assert "reference.radius = 5: there is no such key; did you mean radius_mm?" in second


def test_a_scenario_spells_out_what_counts_only():
    text = hfc.load_scenario("five-axis-program").model_dump(mode="json")["reference"]
    assert "acceleration_mm_s2" not in text
    assert "limits" not in hfc.load_scenario("feed-drive-contour").model_dump()["reference"]
    assert hfc.load_scenario(hfc.load_scenario("five-axis-blade").model_dump(mode="json"))
