"""Programs of any axes: no limit is violated in any cycle, nothing is slower than it need be."""

from time import process_time

import numpy as np
import pytest

from hfc_design.motion import gcode
from hfc_design.motion.axis_path import AxisPath, Bounds, look_ahead
from hfc_design.motion.limits import AxisLimits, MovedAxis
from hfc_design.motion.program import program

AXES = ("x", "y", "z", "a", "c")
CYCLE = 0.002
#: Of Lin & Gai 2009, Table 1 [mm/s or deg/s; the same / s].
VELOCITY = np.array([30e3, 40e3, 40e3, 20e3, 30e3]) / 60.0
RAPID = np.array([20e3, 20e3, 20e3, 15e3, 18e3]) / 60.0
ACCELERATION = RAPID / np.array([0.4, 0.4, 0.4, 0.6, 0.6])
BOUNDS = Bounds(VELOCITY, RAPID, ACCELERATION)


def planned(text, bounds=BOUNDS, axes=AXES):
    path = AxisPath.of(gcode.blocks(text), axes)
    return path, look_ahead(path, bounds, CYCLE)


def positions(path, motion, shift=0.0):
    """(axes, cycles) where the interpolator is, ``shift`` of a cycle late."""
    time = (np.arange(-2, int(motion.duration / CYCLE) + 4) + shift) * CYCLE
    return path.at(motion.at(time)[0]).position


def random_program(rng):
    """Blocks of 3 um to 30 mm on up to five axes, some of them sharp corners, rapids, helices."""
    lines = [f"G91 G61G05.1Q1 F{rng.choice([100, 1000, 10000, 30000])}"]
    scale, direction = 10 ** rng.uniform(-2.5, 1.5), rng.normal(size=5)
    for _ in range(rng.integers(1, 60)):
        direction = rng.normal(size=5) if rng.random() < 0.1 else direction
        direction = direction + rng.normal(size=5) * 10 ** rng.uniform(-3, 0)
        steps = direction * scale * 10 ** rng.uniform(-1, 0.3)
        if rng.random() < 0.1:
            code, x, z, i = (("G17", *"XZI"), ("G18", *"ZYK"), ("G19", *"YXJ"))[rng.integers(3)]
            turn = f"{code} G3 {x}{2 * scale:.4f} {i}{scale:.4f} P{rng.integers(1, 4)}"
            lines.append(f"{turn} {z}{steps[2]:.4f} A{steps[3]:.4f}")
            continue
        if rng.random() < 0.1:
            lines.append(f"G4 P{rng.random():.3f}")
        words = [f"{x}{step:.4f}" for x, step in zip("XYZAC", steps, strict=True)]
        lines.append(("G0 " if rng.random() < 0.1 else "G1 ") + " ".join(words))
    return "\n".join(lines)


def test_no_limit_is_violated_in_any_cycle_of_random_programs():
    rng, tightest = np.random.default_rng(3), 0.0
    for k in range(150):
        jerk = ACCELERATION * (np.inf, 5.0, 100.0)[k % 3]
        path, motion = planned(random_program(rng), BOUNDS._replace(jerk=jerk))
        found = positions(path, motion, rng.random())
        velocity = np.diff(found) / CYCLE
        change = np.abs(np.diff(velocity) / CYCLE / ACCELERATION[:, None]).max()
        assert (np.abs(velocity) / VELOCITY[:, None]).max() < 1.0 + 1e-9
        assert change < 1.0 + 1e-6
        tightest = max(tightest, change)
        time = np.linspace(0.0, motion.duration, 999)
        way, speed, rate = motion.at(time)
        rounding = 1e-9 if k % 3 else 1e-12  # of differences of ways
        assert speed.max() <= np.minimum(motion.peak, path.feed).max() * (1 + rounding)
        block = path.block(way)
        change = np.diff(rate) / time[1] * path.fastest[:, block[1:]] / jerk[:, None]
        assert (np.abs(change)[:, block[1:] == block[:-1]] < 1.0 + 1e-6).all()
    assert tightest > 0.99  # a limit that no program comes near would prove nothing


def test_a_straight_line_is_a_trapezoid():
    """100 mm at 100 mm/s with 833.3 mm/s2 take 1.12 s."""
    _, motion = planned("G1 X100 F6000")
    assert motion.duration == pytest.approx(1.0 + 100.0 / ACCELERATION[0])
    assert motion.at(np.array([0.06]))[1] == pytest.approx(50.0)


def test_axes_rest_where_a_program_dwells():
    """10 mm at 100 mm/s2 and 10 mm/s take 1.1 s, and 1 s in the middle of 20 mm at once."""
    bounds = BOUNDS._replace(acceleration=np.full(5, 100.0))
    _, motion = planned("G4 P2\nG1 X10 F600\nG4 P.5\nG4 X1\nX20\nG4 P0\nX30", bounds)
    assert motion.duration == pytest.approx(2.0 + 1.1 + 1.5 + 2.1)
    way, speed, _ = motion.at(np.array([1.99, 2.05, 3.1, 4.59, 4.65]))
    assert way == pytest.approx([0.0, 0.125, 10.0, 10.0, 10.125])
    assert speed == pytest.approx([0.0, 5.0, 0.0, 0.0, 5.0], abs=1e-9)


def test_a_square_corner_is_a_stop_and_a_gentle_one_is_not():
    path, motion = planned("G1 X20 F6000\nY20")
    speeds = motion.at(motion.start)[1]
    assert np.flatnonzero(speeds == 0.0).size >= 2  # at the corner and at the end
    _, motion = planned("G1 X20 F6000\nX40 Y0.1")  # 5 mrad: 0.5 mm/s at full feed, 1.7 a cycle
    assert motion.duration == pytest.approx(planned("G1 X40 F6000")[1].duration, rel=0.05)
    assert path.lines.tolist() == [1, 2]


def test_feed_is_that_of_the_tool_tip_or_else_of_the_rotary_axes():
    """RS274/NGC: with X, Y or Z the other axes come along; without, degrees a minute."""
    path, motion = planned("G1 X30 Y40 A100 F600")  # 50 mm
    assert motion.peak == pytest.approx(10.0)
    assert path.on(np.array([0]), np.array([0.0])).direction[3] == pytest.approx(2.0)
    path, motion = planned("G1 A30 C40 F600")
    assert (path.length[0], motion.peak[0]) == pytest.approx((50.0, 10.0))
    # a table that would be too fast slows the tool tip: 333.3 deg/s, 10 deg a mm
    assert planned("G1 X50 A500 F6000")[1].peak == pytest.approx(VELOCITY[3] / 10.0)


def test_inverse_time_is_blocks_a_minute():
    path, motion = planned("G93 G1 X10 A20 F30\nX20 C5 F20\nC25 F12")
    assert (path.length / path.feed).tolist() == pytest.approx([2.0, 3.0, 5.0])
    assert motion.peak.tolist() == pytest.approx([5.0, 10 / 3, 4.0], rel=0.01)
    back = planned("G93 G1 X10 F30\nG94 X20 F600")[0]
    assert back.feed.tolist() == pytest.approx([5.0, 10.0])


def test_rapids_take_the_velocity_of_rapids():
    path, motion = planned("G0 X300 A30")
    assert motion.peak == pytest.approx(RAPID[0])
    path, motion = planned("G0 X30 A300")
    assert path.rate[3, 0] * motion.peak[0] == pytest.approx(RAPID[3])


def test_a_helix_with_a_table_beside_it():
    """Two quarters of radius 10 about (0, 0), 6 mm down and 45 deg on."""
    path, motion = planned("G0 X10\nG3 X-10 Y0 I-10 J0 Z-6 C45 F600")
    length = np.hypot(10 * np.pi, 6.0)
    assert path.length[1] == pytest.approx(length)
    share = np.linspace(0.0, 1.0, 7)
    found = path.on(np.ones(7, int), share * length)
    wanted = [10 * np.cos(np.pi * share), 10 * np.sin(np.pi * share), -6 * share]
    np.testing.assert_allclose(found.position[:3], wanted, atol=1e-12)
    np.testing.assert_allclose(found.position[4], 45 * share, atol=1e-12)
    np.testing.assert_allclose(np.sqrt((found.direction[:3] ** 2).sum(axis=0)), 1.0)
    slopes = np.gradient(found.position[0], share * length, edge_order=2)
    np.testing.assert_allclose(found.direction[0], slopes, atol=0.1)
    low, high = path.spans()
    assert (low[0, 1], high[0, 1], high[1, 1]) == pytest.approx((-10.0, 10.0, 10.0))
    acceleration = np.diff(positions(path, motion), 2) / CYCLE**2
    assert (np.abs(acceleration) <= ACCELERATION[:, None] * (1 + 1e-9)).all()


def test_fifty_thousand_lines_take_seconds():
    turns = np.linspace(0.0, 400.0, 49_998)
    columns = (50 * np.cos(turns), 50 * np.sin(turns), -turns / 10, 30 * np.sin(turns / 3))
    rows = (f"X{x:.4f} Y{y:.4f} Z{z:.4f} A{a:.4f}" for x, y, z, a in np.transpose(columns))
    text = "G1 F3000\n" + "\n".join(rows)
    limits = {axis: AxisLimits(rapid_per_min=2e4, acceleration_time_s=0.4) for axis in AXES}
    axes = tuple(MovedAxis(axis, 1.0, axis in "ac", 500.0) for axis in AXES)
    begun = process_time()
    found = program(gcode.blocks(text), axes, limits, CYCLE)
    samples, _ = found.axis_samples(np.arange(0.0, found.duration_s, CYCLE))
    assert process_time() - begun < 10.0
    assert len(samples[0].reference) > 200_000
    jumps = np.diff(samples[1].reference, 2) / CYCLE**2
    assert np.abs(jumps).max() < ACCELERATION[1] * (1 + 1e-6)
