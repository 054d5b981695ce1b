"""G-code programs of known geometry, and what a bad one is told."""

import re
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wording import refused

from hfc_design.core.records import Record, checked
from hfc_design.files.named_scenario import BUILTIN, load_scenario
from hfc_design.motion import gcode
from hfc_design.motion.limits import AxisLimits, MovedAxis
from hfc_design.motion.paths import Path, motion
from hfc_design.motion.program import program as planned
from hfc_design.motion.trajectories import GCode, PathReference

# Two straights of 20 mm and two half circles of radius 5, one by its centre, one by its radius.
SLOT = """%
O1234 (a slot: G1 X99 Y99 is a comment)
N10 g21 G17 G90 G40 G94 T1 M6 ; head
N20 M3 S1200
G0 X10 Y0 Z2.
G1 Z-1 F100
X30. F600
G3 X30 Y10 I0 J5
G1 X 10
G91 G3 Y-10 R5.
G90 G0 Z5 M9
M30
G1 X0
"""


@pytest.fixture
def program(tmp_path):
    def write(text):
        file = tmp_path / "part.ngc"
        file.write_text(text)
        return file

    return write


@pytest.fixture
def path_of(program):
    return lambda text: Path.of(gcode.read(program(text), rapid=1500.0))


def ends(path):
    """Where each segment ends: (segments, 2)."""
    return path.on(np.arange(len(path.length)), path.length).position.T


def test_slot_with_arcs_in_both_forms(path_of):
    path = path_of(SLOT)
    assert path.length.tolist() == pytest.approx([10.0, 20.0, 5 * pi, 20.0, 5 * pi])
    assert path.curvature.tolist() == pytest.approx([0.0, 0.0, 0.2, 0.0, 0.2])
    assert path.feed.tolist() == [1500.0, 600.0, 600.0, 600.0, 600.0]
    wanted = np.array([[10, 0], [30, 0], [30, 10], [10, 10], [10, 0]])
    np.testing.assert_allclose(ends(path), wanted, atol=1e-12)
    assert not path.corners().any()


@pytest.mark.parametrize(
    ("block", "turn"),
    [
        ("G3 X0 Y10 R10", pi / 2),
        ("G2 X0 Y10 I-10 J0", -3 * pi / 2),
        ("G2 X0 Y10 R10", -pi / 2),  # about (10, 10)
        ("G3 X0 Y10 R-10", 3 * pi / 2),
        ("G3 X-10 Y0 R10", pi),
        ("G3 X10 Y0 I-10", 2 * pi),
        ("G91 G3 X-10 Y10 I-10", pi / 2),
    ],
)
def test_arcs_of_radius_10_from_10_0(path_of, block, turn):
    path = path_of(f"G0 X10\nF300 {block}\n")
    assert path.length[1] == pytest.approx(10 * abs(turn))
    assert path.curvature[1] == pytest.approx(np.sign(turn) / 10)
    whole = abs(turn) == 2 * pi
    wanted = [10, 0] if whole else [-10, 0] if abs(turn) == pi else [0, 10]
    np.testing.assert_allclose(ends(path)[1], wanted, atol=1e-6)


@pytest.mark.parametrize(("plane", "axes", "offsets"), [(19, "YZX", "JKI"), (18, "ZXY", "KIJ")])
def test_arcs_in_all_planes_are_those_in_x_y_with_other_letters(plane, axes, offsets):
    """Of a right-handed system: Z-X, and not X-Z."""
    text = "G17 F600\nG1 X10 Y5 Z1\nG3 X5 Y10 I-5 Z4\nG2 X0 Y5 R5\nG2 I3 J4 P2 Z9\nX-2 Y3 R-2"
    other = text.replace("G17", f"G{plane}").translate(str.maketrans("XYZIJK", axes + offsets))
    three = tuple(MovedAxis(axis, 1.0, False, 500.0) for axis in "xyz")
    limits = {axis.name: AxisLimits(acceleration_per_s2=100.0) for axis in three}
    one, two = (planned(gcode.blocks(x), three, limits, 0.002) for x in (text, other))
    time = np.linspace(0.0, one.duration_s, 200)
    rows = ["XYZ".index(axis) for axis in axes]
    assert two.duration_s == pytest.approx(one.duration_s)
    for found, expected in zip(two.samples(time), one.samples(time), strict=True):
        if found.ndim == 2:
            np.testing.assert_allclose(found[rows], expected, atol=1e-9)
    np.testing.assert_allclose(
        np.transpose(two.path.spans())[:, rows], np.transpose(one.path.spans())
    )


def test_an_axis_pair_other_than_x_and_y_has_the_curvature_of_its_own_order():
    """Left of the motion in X-Z, where the arc from X to -Z turns to the right."""
    axes = tuple(MovedAxis(axis, 1.0, False, 500.0) for axis in "xz")
    limits = {axis.name: AxisLimits(acceleration_per_s2=100.0) for axis in axes}
    arc = planned(gcode.blocks("G18 G1 X10 F600\nG3 X0 Z-10 I-10"), axes, limits, 0.002)
    assert arc.path.curvature.tolist() == pytest.approx([0.0, -0.1])


def test_a_program_in_x_y_rests_for_its_dwells(path_of):
    """10 mm with 100 mm/s2 to 10 mm/s take 1.1 s; Z does not count, its dwells do."""
    path = path_of("G4 P2\nG1 X10 F600\nG4 P.25\nG0 Z5\nG4 U.25\nG1 X20\nG4 X1\n")
    found = motion(path, 100.0)
    assert found.duration == pytest.approx(2.0 + 1.1 + 0.5 + 1.1)
    way, speed, _ = found.at(np.array([0.0, 1.9, 2.05, 3.15, 3.55, 3.65]))
    assert way == pytest.approx([0.0, 0.0, 0.125, 10.0, 10.0, 10.125])
    assert speed == pytest.approx([0.0, 0.0, 5.0, 0.0, 0.0, 5.0])


def test_arc_whose_radii_differ_by_rounding_leaves_no_accumulated_error(path_of):
    """Radii 10 and 10.008: the arc ends 8 um off, the line after it where it should."""
    path = path_of("F300 G0 X10\nG3 X0 Y10.008 I-10\nG1 X-5\n")
    np.testing.assert_allclose(ends(path)[1:], [[0, 10], [-5, 10.008]], atol=1e-12)
    assert path.start[:, 2].tolist() == pytest.approx([0.0, 10.0], abs=1e-12)
    across = path_of("F300 G0 X10\nG3 X0 Y10.008 I-10\nG2 X5 Y15.008 J5\nG1 X9")  # 8 um along it
    np.testing.assert_allclose(ends(across)[:-1].T, across.start[:, 1:], atol=1e-12)


def test_relative_and_absolute_say_the_same(path_of):
    absolute = path_of("G1 X1 Y2 F60\nX4\nG2 X6 Y0 J-2\nG1 Y-3")
    relative = path_of("G91 G1 X1 Y2 F60\nX3\nG2 X2 Y-2 J-2\nG1 Y-3")
    np.testing.assert_allclose(ends(relative), ends(absolute), atol=1e-12)
    np.testing.assert_allclose(relative.length, [np.sqrt(5), 3.0, pi, 3.0])


#: Lin & Gai 2009, fig. 4, as the scan of it reads.
PRINTED = """G61G05.1Q1F10000
X-1.513 Y215.223 Z-164.657 A86.462 C-91.007
X-1.426 Y216.091 Z-165.266 A86.556 C-91.002
X-1.339 Y216.975 Z-165.907 A86.659 C-91.992
X-1.253 Y217.874 Z-166.575 A86.77 C-90.976
X-1.166 Y218.784 Z-167.264 A86.887 C-90.956
X-1.08 Y219.706 Z-167.976 A87.011 C-90.929
X- .992 Y220.635 Z-168.701 A87.139 C-90.898
X- .905 Y221.572 Z-169.443 A87.272 C-90.86
X- 82 Y222.512 Z-170.194 A87.408 C-90.815
X- .733 Y223.458 Z-170.958 A87.548 C-90.765
X- .648 Y224.408 Z-171.732 A87.691 C-90.707
M2
"""


def test_blanks_in_numbers_mean_nothing():
    """As in RS274/NGC, 3.3: so X- 82, which was to be -.82, is -82."""
    found = gcode.blocks(PRINTED, (-1.0, 215.0, -150.0, 86.0, 0.0, -91.0))
    x = [-1.513, -1.426, -1.339, -1.253, -1.166, -1.08, -0.992, -0.905, -82.0, -0.733, -0.648]
    assert [block.end[0] for block in found] == x
    assert [block.end[5] for block in found][2] == -91.992
    assert {block.feed for block in found} == {10000.0}
    assert found[0].length == pytest.approx(np.hypot(np.hypot(0.513, 0.223), 14.657))
    (block,) = gcode.blocks("g1 x +0. 12 34 y 7 f6 0")
    assert (*block.end[:2], block.feed) == (0.1234, 7.0, 60.0)


@pytest.mark.parametrize("name", ["printed", "corrected"])
def test_programs_of_the_paper_are_what_they_say(name):
    """Only what their comments tell of differs from the scan."""
    text = (BUILTIN / f"five-axis-program-{name}.ngc").read_text()
    scan = PRINTED.replace("X- 82", "X- .82")
    if name == "corrected":
        scan = scan.replace("C-91.992", "C-90.992")
    start = (-1.0, 215.0, -150.0, 86.0, 0.0, -91.0)
    first = text.split("\n").index(next(x for x in text.split("\n") if x.startswith("G61")))
    found = [block._replace(line=block.line - first) for block in gcode.blocks(text, start)]
    assert found == [*gcode.blocks(scan, start)]


def test_a_mode_is_straight_until_a_program_says_another():
    """As the program above wants it; without any feed nobody knows what is meant."""
    assert gcode.blocks("F60\nA5")[0].end[3] == 5.0
    with refused(ValueError) as found:
        gcode.blocks("A5")
    assert found.where == "line 1"


def test_windows_files_are_read(program):
    file = program("")
    file.write_bytes(b"\xef\xbb\xbfG1 F60 X1\r\n(caf\xe9)\r\nX2\r\n")
    assert len(gcode.read(file, rapid=1500.0)) == 2


@settings(deadline=None)
@given(st.lists(st.tuples(*[st.floats(-999, 999)] * 2), min_size=1, max_size=9))
def test_any_points_come_back(tmp_path_factory, points):
    file = tmp_path_factory.getbasetemp() / "points.ngc"
    lines = [f"G1 X{x:.6f} Y{y:.6f}" for x, y in points]
    file.write_text("\n".join(["F100", *lines]))
    corners = np.round(np.array([(0.0, 0.0), *points]), 6)
    moved = np.hypot(*np.diff(corners, axis=0).T) >= 1e-6
    if moved.any():
        path = Path.of(gcode.read(file, rapid=1.0))
        total = np.hypot(*np.diff(corners, axis=0).T).sum()
        assert path.knots[-1] == pytest.approx(total, abs=1e-4)
        np.testing.assert_allclose(ends(path)[-1], corners[-1], atol=2e-5)


#: What many programs begin with -> the same moves without it, and the first words of the notes.
READ = {
    "G17 G40 G49 G80 G94 M48\n/ G1 F60 X1\n": ("G1 F60 X1\n", ["line 2: blocks"]),
    "%\nO0001 (part)\nG1 F60 X1\n%\nX9 Q7 (outside)\n": ("G1 F60 X1\n", []),
    "G1 F60 X1\nG4 P0.5\nX5\n": ("G1 F60 X1\nX5\n", ["line 2: G4"]),
    "G28 G91 Z0\nG90 G1 F60 X1\nG53 G0 Z0\nX5\n": (
        "G1 F60 X1\nG0 X5\n",
        ["line 1: G28", "line 3: G53"],
    ),
    "G43.1 Z9\nG98 G97 G8 M19 G1 F60 X1\n": ("G1 F60 X1\n", ["line 1: G43.1", "line 2: G98"]),
    "G64 P0.01 Q0.02\nG1 F60 X1\nG64\n": ("G1 F60 X1\n", ["line 1: G64"]),
    "G43 H1 Z10 F60\nG1 X5\n": ("F60 G1 Z10\nX5\n", ["line 1: G43"]),
    "F60 G18\nG1 X1 Z2\nG17\nG2 X3 I1 K0\n": ("F60\nG1 X1 Z2\nG2 X3 I1\n", []),
    "F60 G90.1\nG1 X1 Y1\nG3 X3 I2 J1\n": ("F60\nG1 X1 Y1\nG3 X3 I1 J0\n", []),
    # 0.1 mm or 0.01 inch a revolution, at 500 and 200 rev/min
    "G95 S500 M3 F.1\nG1 X1\nS200 A9\nM5 G94 F7\nX0\nM4 G20 G95 F.01 X1\n": (
        "F50\nG1 X1\nF20 A9\nF7 X0\nF50.8 X25.4\n",
        [],
    ),
    # An inch is 25.4 mm; where only tables move F is in deg/min.
    "G20 F10\nG1 X1 Y-.5\nG2 X2 I.5\nG1 A90\n": (
        "F254\nG1 X25.4 Y-12.7\nG2 X50.8 I12.7\nG1 F10 A90\n",
        [],
    ),
    "G20\nG1 X1 F1\nG21 F60 X0\n": ("G1 X25.4 F25.4\nX0 F60\n", []),
}


@pytest.mark.parametrize("text", READ)
def test_what_changes_nothing_or_has_one_meaning_is_read(text):
    plain, told = READ[text]
    found, expected = gcode.blocks(text), gcode.blocks(plain)
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        assert one.end == pytest.approx(other.end)
        assert one.feed == pytest.approx(other.feed)
        assert (one.centre or ()) == pytest.approx(other.centre or ())
        assert one.sweep == pytest.approx(other.sweep)
    noted = gcode.notes(text)
    assert all(map(str.startswith, noted, told))
    assert len(noted) == len(told)


#: Programs, by the line that is at fault; by 0 what has nothing that moves.
BAD = {
    0: [
        "",
        "G21 G90 (nothing)\nM30\n",
        "G0 X0 Y0\nG1 F5 Z-3\nM2\nX5\n",
    ],
    1: [
        "G1 F60 X Y2\n",
        "G1 F60 X1 E5\n",
        "G1 F60 X1e5\n",
        f"G1 F60 X{'9' * 400}\n",
        "G1 F60 X1 X2\n",
        "G1 F60 X1,5\n",
        "G1 F60 X1 Q1\n",
        "G93 G1 X1 F0\n",
        "G42 D1\nG1 F60 X1\n",
        "G55\nG1 F60 X1\n",
        "G96 S100\nG1 F60 X1\n",
        "G33 Z-9 K1\n",
        "G81 X1 Z-9 R1 F60\n",
        "G7\nG1 F60 X1\n",
        "G4\nG1 F60 X1\n",
        "G4 P-1\nG1 F60 X1\n",
        "G4 P1 X2\nG1 F60 X1\n",
        "M98 P1000\n",
        "o100 sub\nG1 F60 X1\n",
        "O<part> call [1]\nG1 F60 X1\n",
        "G1 F60 X[1+2]\n",
        "G1 F60 X\uff11\n",
        "G1 F-5 X2\n",
        "G0 G1 X1\n",
        "G1 F60 X1 Z1\n",
        "G1 F60 X1 I1\n",
        "G1 F60 X1 P2\n",
    ],
    2: [
        f"F60\nG2 X1 R1{'0' * 200}\n",
        "G1 F60 X1\n#1=5\n",
        "G93 F2\nG1 X1\n",
        "G1 F60 X1\nA5\n",
        "G0 X1\nG1 X2\n",
        "G0 X1\nG2 X2 I1\n",
        "F60\nG2 X1 I0 J0\n",
        "F60\nG2 X2 I1 R1\n",
        "F60\nG2 X0 R1\n",
        "F60\nG2 X3 R1.48\n",
        "F60\nG2 X2.02 I1\n",
        "F60 G18\nG2 X2 I1\n",
        "F60 G18\nG2 I1\n",
        "F60 G19\nG2 X2 I1\n",
        "F60\nG2 X2 I1 K1\n",
        "F60\nG2 X2 I1 P1.5\n",
        "F60\nG2 X2 I1 P0\n",
        "F60 G90.1\nG2 X2 I1\n",
        "G95 M3 F60\nG1 X1\n",
        "G95 S9 F60\nG1 X1\n",
    ],
    3: [
        "F60\nG3 X2 I1.005\nG2 X2.01 I.005\n",
        "G1 F60 X1\n\nX\n",
        "G1 F60 Z1\nX1 Z1\nX2 Z0\n",
    ],
    4: [
        "F60\nG1 X1\nX2\nX１\n",
        "F60\nG93 G1 X1 F2\nG94\nX2\n",
    ],
}


@pytest.mark.parametrize(("line", "text"), [(line, text) for line in BAD for text in BAD[line]])
def test_bad_program_is_one_line(program, line, text):
    file = program(text)
    with refused() as found:
        gcode.read(file, rapid=1500.0)
    assert found.where == (f"{file}: line {line}" if line else str(file))
    assert "\n" not in found.refusal


@settings(deadline=None)
@given(
    st.text(alphabet="GXYZACIJKRFMPS01289.- \n(;%", max_size=80).map(lambda text: f"G1 F60 {text}")
)
def test_any_text_can_be_run_on_six_axes_or_is_refused(text):
    try:
        found = gcode.blocks(text)
    except ValueError as error:
        assert re.match(r"line \d+: ", str(error))
        return
    if found:
        axes = tuple(MovedAxis(axis, 1.0, axis in "abc", 500.0) for axis in "xyzabc")
        limits = {axis.name: AxisLimits(acceleration_per_s2=800.0) for axis in axes}
        run = planned(found, axes, limits, 0.002)
        assert run.motion.finite
        assert run.path.at(run.path.knots[-1:]).position[:, 0] == pytest.approx(found[-1].end)


def test_missing_file_and_folder(tmp_path):
    for file in (tmp_path / "none.ngc", tmp_path):
        with refused() as found:
            gcode.read(file, rapid=1500.0)
        assert found.where == str(file)


class Holder(Record):
    reference: PathReference


def test_reference_finds_its_program_beside_the_scenario(program):
    file = program(SLOT)
    data = {"reference": {"kind": "gcode", "file": "part.ngc", "acceleration_mm_s2": 1e6}}
    held = checked(Holder, data, "mine.toml", file.parent).reference
    assert isinstance(held, GCode)
    # 1 m/s2 and more: what is left of the ramps is 0.1 ms.
    assert held.duration_s == pytest.approx(0.4 + 4 + 2 * pi / 2, abs=1e-3)
    file.write_text("G1 X1\n")
    with refused() as found:
        checked(Holder, data, "mine.toml", file.parent)
    assert found.refusal.startswith("mine.toml: reference.file = ")
    data["reference"]["kind"] = "spiral"
    with refused() as found:
        checked(Holder, data, "mine.toml", file.parent)
    assert found.refusal.startswith("mine.toml: reference")


def test_a_program_that_would_be_read_for_long_is_refused():
    with refused(ValueError):
        gcode.segments("G1 X1 F100\n" + "\n" * 49_999 + "X2", 1000.0)


def test_a_file_in_a_change_lies_where_the_user_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.ngc").write_text("G1 X10 Y5 F300\n")
    change = "reference={kind='gcode', file='mine.ngc'}"
    assert load_scenario("feed-drive-circle", [change]).reference.duration_s > 2.0
    assert load_scenario("feed-drive-contour").reference.duration_s > 20.0


@pytest.mark.parametrize("end", ["M2", "M30 "])
def test_what_stands_behind_the_end_of_a_program_is_no_code(end):
    text = f"G21\nG4 P1\nG1 X2 F100\n{end}\nTool list: T1 end mill\nG43 H1"
    assert len(gcode.blocks(text)) == 1
    assert [line.split(":")[0] for line in gcode.notes(text)] == ["line 2"]


def test_feed_is_modal_and_moves_to_the_same_place_are_none(path_of):
    path = path_of("G1 F60 X1\nX1\nX2\nF90\nX3\nG0 X3\n")
    assert path.feed.tolist() == [60.0, 60.0, 90.0]
