"""How far a machine is off a program of any axes, against a search by brute force and by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.motion import gcode
from hfc_design.motion.contour import nearest as nearest_in_the_plane
from hfc_design.motion.contour import off_path
from hfc_design.motion.limits import AxisLimits, MovedAxis
from hfc_design.motion.program import program
from hfc_design.motion.samples import PathFrame
from hfc_design.motion.tool_path import nearest, program_errors


def take(part, k):
    """Sample ``k`` of a field of a path."""
    if isinstance(part, tuple):
        return tuple(None if one is None else one[k] for one in part)
    return part[k]


AXES = tuple(MovedAxis(axis, 1.0, axis in "ac", 500.0) for axis in "xyzac")
LIMITS = {axis.name: AxisLimits(acceleration_per_s2=800.0) for axis in AXES}
PART = """G1 F3000 X20 A10
X40 Y15 Z-5 C-30
G3 X40 Y35 I0 J10 Z-9 A25 F2000
G1 X38 Y35.2
G91 A5 C5 F900
X-30 Z4
"""


@pytest.fixture(scope="module")
def part():
    return program(gcode.blocks(PART), AXES, LIMITS, 0.002)


@pytest.fixture(scope="module")
def moved(part):
    """A machine that lags and swings about where it should be; times, samples and places."""
    time = np.arange(0.0, part.duration_s, 0.01)
    rng = np.random.default_rng(1)
    swing = rng.normal(size=(5, 4)) @ np.sin(np.outer([3.0, 7.0, 11.0, 17.0], time))
    behind = part.samples(np.maximum(time - 0.02, 0.0)).position
    return time, part.samples(time), behind + 0.1 * swing


def lagging(scenario):
    """Axes that lag as those of the published PID do, each by a time of its own, and swing."""
    program, time = scenario.path, scenario.simulation.time
    samples = program.samples(time)
    late = program.samples(np.maximum(time - 0.03, 0.0)).position
    axes = len(late)
    lag = np.array([0.9, 0.4, 0.9, 0.2, 0.3])[:axes, None]
    swing = 0.02 * np.sin(np.outer([7.0, 11.0, 13.0, 17.0, 19.0][:axes], time))
    return program, samples, samples.position + lag * (late - samples.position) + swing


def of_chords(program, samples, actual, long=0.02):
    """Contour error and error of the orientation by chords of the whole path, sample by sample."""
    linear, path = program.linear, program.path
    ways = np.unique(np.concatenate([path.knots, np.arange(0.0, path.knots[-1], long)]))
    comb = path.at(ways).position
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(comb[linear]), axis=0))])
    commanded = np.interp(samples.distance, ways, along)
    for k, (place, there) in enumerate(zip(actual.T, commanded, strict=True)):
        found = []
        for squares in (np.where(linear, 1.0, 0.0), np.where(linear, 1.0, 0.05**2)):
            far = 4.0 * np.sqrt(squares @ (place - samples.position[:, k]) ** 2)
            ends = np.clip([there - far, there + far], 0.0, along[-1])
            low, high = np.searchsorted(along, ends)
            around = slice(max(low - 1, 0), high + 1)
            first, last = np.stack([np.interp(ends, along[around], x[around]) for x in comb], 1)
            near = np.column_stack([first, comb[:, low:high], last])
            start, chord = near[:, :-1], np.diff(near)
            length = np.maximum(squares @ chord**2, 1e-300)
            share = np.clip(squares @ (chord * (place[:, None] - start)) / length, 0.0, 1.0)
            off = place[:, None] - start - share * chord
            found.append(off[:, (squares @ off**2).argmin()])
        yield k, np.linalg.norm(found[0][linear]), np.linalg.norm(found[1][~linear])


def test_errors_are_those_of_a_fine_comb(part, moved):
    _, samples, actual = moved
    found = nearest(part, samples, actual)
    assert not part.path.linear[part.path.block(samples.distance)].all()
    for k, contour_error, turned in of_chords(part, samples, actual):
        assert found.contour_error[k] == pytest.approx(contour_error, rel=1e-3, abs=1e-6)
        assert found.turned[k] == pytest.approx(turned, rel=1e-3, abs=1e-3)


def test_on_the_turns_of_a_thread_the_nearest_turn_counts():
    """Of radius 1 mm and pitch 0.5 mm, with a lag that reaches over several turns."""
    thread = program(gcode.blocks("G1 F3000 X9\nG18 G2 K1 Y-3 P6 A60 F2000"), AXES, LIMITS, 0.002)
    samples = thread.samples(np.arange(0.0, thread.duration_s, 0.03))
    late = thread.samples(np.arange(0.0, thread.duration_s, 0.03) - 0.1).position
    actual = late + np.array([[0.1], [0.02], [-0.1], [0.3], [0.0]])
    found = nearest(thread, samples, actual)
    for k, contour_error, turned in of_chords(thread, samples, actual):
        assert found.contour_error[k] == pytest.approx(contour_error, rel=1e-2, abs=1e-3)
        assert found.turned[k] == pytest.approx(turned, rel=1e-2, abs=1e-2)


@pytest.mark.parametrize("name", [f"five-axis-{x}" for x in ("program", "robust")])
def test_errors_in_the_built_in_programs_are_those_of_a_fine_comb(name):
    """At every sample."""
    program, samples, actual = lagging(load_scenario(name))
    found = nearest(program, samples, actual)
    for k, contour_error, _ in of_chords(program, samples, actual):
        assert found.contour_error[k] == pytest.approx(contour_error, rel=1e-3, abs=1e-6)


def test_so_are_those_of_programs_in_x_and_y():
    program, samples, actual = lagging(load_scenario("feed-drive-contour"))
    found = np.abs(nearest_in_the_plane(program, samples, actual).error)
    flat = SimpleNamespace(path=program.path, linear=np.array([True, True]))
    for k, contour_error, _ in of_chords(flat, samples, actual, 0.004):
        assert found[k] == pytest.approx(contour_error, rel=1e-3, abs=1e-6)


def test_a_tip_that_lags_on_the_path_is_on_it_while_tables_turn():
    """X is 3 mm behind on its line and 0.2 mm beside it; A is where it should be, or 1 deg off."""
    turning = program(gcode.blocks("G1 F6000 X50\nA30 F600\nX60 Y10"), AXES, LIMITS, 0.002)
    time = np.arange(0.0, turning.duration_s, 0.01)
    samples = turning.samples(time)
    middle = np.abs(samples.position[3] - 15.0).argmin()
    off = np.array([-3.0, 0.0, 0.2, 0.0, 0.0])
    actual = samples.position + off[:, None]
    assert nearest(turning, samples, actual).contour_error[middle] == pytest.approx(0.2)
    _, frame = turning.axis_samples(time)
    now = PathFrame(*(take(part, middle) for part in frame))
    assert off_path(now, off) == pytest.approx((0.2, 0.0, 0.0))
    assert off_path(now, off + np.array([0.0, 0.0, 0.0, -1.0, 0.5])) == pytest.approx(
        (0.2, 0.5, -1.0)
    )


def test_where_only_tables_turn_their_lag_is_no_error():
    """10 mm off in X all along; A and C behind by 3 and 4 deg on the way, and 1 deg beside it."""
    turning = program(gcode.blocks("G1 A30 C40 F600"), AXES, LIMITS, 0.002)
    samples = turning.samples(np.array([2.0]))
    actual = samples.position + np.array([[10.0], [0.0], [0.0], [-3.0 + 0.8], [-4.0 - 0.6]])
    found = nearest(turning, samples, actual)
    assert found.contour_error == pytest.approx([10.0])
    assert found.turned == pytest.approx([1.0])


def test_the_control_knows_the_same_near_the_path(part, moved):
    """Off by hundredths, the parabola is as good as the path; corners are left out."""
    time, samples, actual = moved
    actual = samples.position + 0.2 * (actual - samples.position)
    _, frame = part.axis_samples(time)
    told = off_path(frame, list(actual - samples.position))
    found = nearest(part, samples, actual)
    corners = np.abs(samples.distance[:, None] - part.path.knots).min(axis=1)
    inside = (corners > 1.5) & part.path.linear[part.path.block(samples.distance)]
    assert inside.sum() > 100
    np.testing.assert_allclose(told.contour[inside], found.contour_error[inside], atol=1e-3)
    np.testing.assert_allclose(told.orientation[inside], found.turned[inside], atol=2e-2)
    straight = inside & (part.path.turning[part.path.block(samples.distance)] == 0.0)
    np.testing.assert_allclose(told.contour[straight], found.contour_error[straight], atol=1e-5)
    np.testing.assert_allclose(told.orientation[straight], found.turned[straight], atol=5e-4)


def test_errors_known_by_hand():
    """Along (3, 4, 0)/5 with 2 deg a mm: 1 mm behind, 2 to the side and 3 up, 5 deg turned."""
    t = (0.6, 0.8, 0.0, 2.0)
    frame = PathFrame(t, 0.0, 1.0, 1.0, bend=(0.0, 0.0, 0.0, None), only_turning=0.0)
    off = (-0.6 + 2 * -0.8, -0.8 + 2 * 0.6, 3.0, 5.0 - 2.0)
    assert off_path(frame, off) == pytest.approx((np.sqrt(13.0), 5.0, -1.0))
    flat = PathFrame((1.0, 0.0), 0.1, 1.0, 1.0)  # 8 mm from the centre of a circle of 10
    assert off_path(flat, (0.0, 2.0)).contour == pytest.approx(2.0)
    assert off_path(flat, (0.0, 2.0)).orientation is None


def test_a_reversal_of_a_table_and_of_a_slide_are_told_apart():
    back = program(gcode.blocks("G1 X20 A10 F3000\nX30 A0\nX20"), AXES, LIMITS, 0.002)
    time = np.arange(0.0, back.duration_s, 0.002)
    found = program_errors(back, time, back.samples(time).position + 0.01, "mm")
    assert [glitch.axis for glitch in found.glitches] == ["x"]
    assert [glitch.axis for glitch in found.turned_glitches] == ["a"]
