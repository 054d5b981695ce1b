"""Five axes through a program in the closed loop: what PID control does by hand, and bad input."""

import pytest

import hfc_design.api as hfc


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
