"""References and loads by hand, and what a bad CSV file is told."""

from math import cos, pi, sin

import numpy as np
import oracle
import pytest
from scipy.interpolate import CubicSpline
from wording import refused

from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.motion.references import (
    Load,
    LoadSine,
    Ramp,
    Sine,
    Step,
    Table,
    Trapezoidal,
)
from hfc_design.motion.samples import Simulation


def at(reference, *times):
    return reference.samples(np.array(times)).target.tolist()


def rate(reference, *times):
    return reference.samples(np.array(times)).reference_rate.tolist()


def load_at(load, *times):
    return load.at(np.array(times)).tolist()


def test_ramp():
    assert at(Ramp(), 0.0, 1.5) == pytest.approx([0.0, 0.03])
    assert rate(Ramp(velocity=-0.5), 0.0, 1.5) == [-0.5, -0.5]


def test_sine():
    sine = Sine(amplitude=0.2, frequency_rad_s=3.0)
    assert at(sine, 0.0, pi / 6, 1.0) == pytest.approx([0.0, 0.2, 0.2 * sin(3)])
    assert rate(sine, 0.0, pi / 6, 1.0) == pytest.approx([0.6, 0.0, 0.6 * cos(3)], abs=1e-15)


def test_step():
    jump = Step(height=0.005, time_s=0.1)
    assert at(jump, 0.0, 0.0999, 0.1, 2.0) == [0.0, 0.0, 0.005, 0.005]
    assert rate(jump, 0.0, 0.1, 2.0) == [0.0, 0.0, 0.0]
    assert at(Step(height=1.0), 0.0) == [1.0]


def test_trapezoidal():
    """1 rad at up to 0.5 rad/s and 2 rad/s2: 0.25 s up, 1.75 s even, 0.25 s down."""
    move = Trapezoidal(distance=1.0, velocity=0.5, acceleration=2.0)
    times = (0.0, 0.1, 0.25, 1.25, 2.0, 2.15, 2.25, 9.0)
    assert at(move, *times) == pytest.approx(
        [0.0, 0.01, 0.0625, 0.5625, 0.9375, 0.99, 1.0, 1.0], abs=1e-15
    )
    assert rate(move, *times) == pytest.approx([0.0, 0.2, 0.5, 0.5, 0.5, 0.2, 0.0, 0.0], abs=1e-15)


def test_trapezoidal_too_short_for_its_velocity_is_a_triangle():
    """-0.5 rad at 2 rad/s2 peaks at 1 rad/s after 0.5 s and ends after 1 s."""
    move = Trapezoidal(distance=-0.5, velocity=3.0, acceleration=2.0)
    times = (0.0, 0.25, 0.5, 0.75, 1.0, 2.0)
    assert at(move, *times) == pytest.approx([0.0, -0.0625, -0.25, -0.4375, -0.5, -0.5])
    assert rate(move, *times) == pytest.approx([0.0, -0.5, -1.0, -0.5, 0.0, 0.0])


def test_a_limit_of_the_jerk_rounds_a_move():
    """The mean of 0.1 s = a / j of a move: the acceleration rises for 0.1 s, then as before."""
    move = Trapezoidal(distance=1.0, velocity=0.5, acceleration=2.0, jerk=20.0)
    assert move.duration_s == pytest.approx(2.25 + 0.1)
    times = (0.0, 0.05, 0.1, 0.25, 0.35, 1.175, 2.3, 2.35, 9.0)
    small = 20.0 * 0.05**3 / 6
    by_hand = [0.0, small, 1 / 300, 1 / 300 + 0.015 + 0.0225, 0.0875, 0.5, 1 - small, 1.0, 1.0]
    assert at(move, *times) == pytest.approx(by_hand, abs=1e-15)
    by_hand = [0.0, 0.025, 0.1, 0.4, 0.5, 0.5, 0.025, 0.0, 0.0]
    assert rate(move, *times) == pytest.approx(by_hand, abs=1e-14)
    found = move.samples(np.array(times)).reference_acceleration
    assert found == pytest.approx([0.0, 1.0, 2.0, 2.0, 0.0, 0.0, -1.0, 0.0, 0.0], abs=1e-12)


def test_a_short_move_brakes_at_once_and_needs_twice_the_time_for_its_jerk():
    """-0.5 rad in 1 s without; from 2 to -2 rad/s2 in 0.2 s, so that the peak is 0.9 rad/s."""
    move = Trapezoidal(distance=-0.5, velocity=3.0, acceleration=2.0, jerk=20.0)
    assert move.duration_s == pytest.approx(1.2)
    assert rate(move, 0.6) == pytest.approx([-0.9])
    assert at(move, 0.6, 1.2, 3.0) == pytest.approx([-0.25, -0.5, -0.5], abs=1e-15)
    step = 0.004
    third = np.diff(move.samples(np.arange(-0.1, 1.4, step)).target, 3) / step**3
    assert np.abs(third).max() == pytest.approx(20.0, rel=1e-6)
    assert at(Trapezoidal(distance=0.0, velocity=3.0, acceleration=2.0, jerk=20.0), 1.0) == [0.0]


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "angle.csv"
    path.write_text("time_s,angle_rad\n1.0,2.0\n2.0,2.5\n4.0,1.5\n")
    return Table(file=path)


def test_table(table):
    times = (0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0)
    assert at(table, *times) == pytest.approx([2.0, 2.0, 2.25, 2.5, 2.0, 1.5, 1.5])
    assert rate(table, *times) == pytest.approx([0.0, 0.5, 0.5, -0.5, -0.5, 0.0, 0.0])


def test_a_table_without_a_header_keeps_its_first_row(table, tmp_path):
    bare = tmp_path / "bare.csv"
    bare.write_text("1.0,2.0\n2.0,2.5\n4.0,1.5\n")
    assert at(Table(file=bare), 1.0, 1.5, 3.0) == at(table, 1.0, 1.5, 3.0)


def test_a_cubic_table_is_smooth_and_has_an_acceleration(tmp_path):
    """Exact on a cubic, near a sine of which it has 16 rows a turn; at rest outside."""
    path, rows = tmp_path / "cubic.csv", np.array([0.5, 1.0, 1.75, 2.0, 3.5])
    np.savetxt(path, np.c_[rows, 2.0 * rows**3 - rows**2], delimiter=",")
    time = np.array([0.5, 0.8, 2.9])
    found = Table(file=path, interpolation="cubic").samples(time)
    np.testing.assert_allclose(found.target, 2.0 * time**3 - time**2, rtol=1e-12)
    np.testing.assert_allclose(found.reference_rate, 6.0 * time**2 - 2.0 * time, rtol=1e-11)
    np.testing.assert_allclose(found.reference_acceleration, 12.0 * time - 2.0, rtol=1e-10)
    outside = Table(file=path, interpolation="cubic").samples(np.array([0.0, 3.5, 9.0]))
    assert outside.target == pytest.approx([0.0, 73.5, 73.5])
    assert not outside.reference_rate.any()
    assert not outside.reference_acceleration.any()
    rows = np.arange(49) * np.pi / 8
    np.savetxt(path, np.c_[rows, np.sin(rows)], delimiter=",")
    middle = np.linspace(6.0, 12.0, 200)
    found = Table(file=path, interpolation="cubic").samples(middle)
    np.testing.assert_allclose(found.reference_acceleration, -np.sin(middle), atol=0.02)


def test_a_cubic_table_through_moves_only_is_one_spline(tmp_path):
    """Against SciPy's own, with a rest at one end and without."""
    path, rows = tmp_path / "way.csv", np.array([0.0, 1.0, 2.5, 3.0, 4.0, 6.0])
    values, time = np.sin(rows), np.linspace(0.0, 5.9, 60)
    np.savetxt(path, np.c_[rows, values], delimiter=",")
    found = Table(file=path, interpolation="cubic").samples(time)
    np.testing.assert_allclose(found.target, CubicSpline(rows, values)(time), atol=1e-14)
    np.savetxt(path, np.c_[np.append(rows, 7.0), np.append(values, values[-1])], delimiter=",")
    found = Table(file=path, interpolation="cubic").samples(time)
    clamped = CubicSpline(rows, values, bc_type=("not-a-knot", "clamped"))
    np.testing.assert_allclose(found.target, clamped(time), atol=1e-14)
    beside = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0])  # two rows beside a turning point
    np.savetxt(path, np.c_[np.arange(6.0), beside], delimiter=",")
    found = Table(file=path, interpolation="cubic").samples(np.array([2.5]))
    assert found.target[0] == pytest.approx(CubicSpline(np.arange(6.0), beside)(2.5), abs=1e-14)
    assert found.target[0] > 2.0


def test_rate_is_the_derivative_of_the_angle(table):
    references = (
        Ramp(velocity=0.3),
        Sine(amplitude=0.2, frequency_rad_s=3.0),
        Step(height=0.1, time_s=0.7),
        Trapezoidal(distance=1.0, velocity=0.5, acceleration=2.0),
        Trapezoidal(distance=-0.5, velocity=3.0, acceleration=2.0),
        Trapezoidal(distance=1.0, velocity=0.5, acceleration=2.0, jerk=7.0),
        table,
    )
    h = 1e-5
    time = np.arange(0.013, 5.0, 0.0271)  # no corner is nearer than h to one of these
    for reference in references:
        after, before = (reference.samples(time + step).target for step in (h, -h))
        found = reference.samples(time).reference_rate
        np.testing.assert_allclose(found, (after - before) / (2 * h), atol=1e-9)


def test_load_of_equation_7():
    load = load_scenario("c-axis-ramp-cutting").load
    times = (0.0, pi / 2, 0.8, 3.21)
    assert load_at(load, *times) == pytest.approx([oracle.cutting_load(t) for t in times])
    assert load_at(load, 0.0) == pytest.approx([5 + 0.5**0.5])  # 5 + 0 + sin(pi / 4)
    assert load_at(load, pi / 2) == pytest.approx([7 + sin(25 * pi + pi / 4)])


def test_load_adds_a_constant_sines_and_a_table(table):
    sines = (LoadSine(amplitude=3.0, frequency_rad_s=2.0, phase_rad=pi / 2),)
    load = Load(constant=1.0, sines=sines, file=table.file)
    assert load_at(load, 0.0, 1.5) == pytest.approx([1 + 3 + 2.0, 1 + 3 * cos(3.0) + 2.25])
    assert load_at(Load(), 0.0, 1.0) == [0.0, 0.0]


def test_samples_hold_the_load_where_the_integrator_needs_it():
    scenario = load_scenario("c-axis-ramp-cutting", ["simulation.substeps=2"])
    samples = scenario.samples()
    (axis,) = samples.axes
    assert axis.loads.shape == (5, 10_000)
    for k in range(5):  # 2 substeps of 0.5 ms: their starts, middles and ends
        wanted = oracle.cutting_load(0.777 + k * 0.00025)
        assert axis.loads[k, 777] == pytest.approx(wanted, rel=1e-12)
    assert axis.reference[777] == pytest.approx(0.02 * 0.777)
    assert (axis.reference_rate == 0.02).all()
    assert samples.settled.tolist() == [0.0] * 1000 + [1.0] * 9000  # from 1 s on
    brief = load_scenario("c-axis-ramp", ["simulation.duration_s=0.5"]).samples()
    assert (brief.settled == 1.0).all()  # it ends earlier and is looked at as a whole


def scenario_with(folder, csv, section="reference"):
    """A scenario in ``folder`` that reads ``angle.csv`` beside it; no file where csv is None."""
    if csv is not None:
        (folder / "angle.csv").write_text(csv)
    kind = 'kind = "csv"\n' if section == "reference" else ""
    path = folder / "own.toml"
    path.write_text(f'[{section}]\n{kind}file = "angle.csv"\n')
    return str(path)


BAD = {
    "missing": None,
    "one column": "t\n0\n1\n",
    "three columns": "t,a,b\n0,1,2\n1,2,3\n",
    "time stands": "t,a\n0,1\n0,2\n",
    "nan": "t,a\n0,1\n1,nan\n",
    "too large": "t,a\n0,1\n1,1e308\n",
}


@pytest.mark.parametrize("section", ["reference", "load"])
@pytest.mark.parametrize("csv", BAD)
def test_bad_csv_is_one_line(tmp_path, section, csv):
    path = scenario_with(tmp_path, BAD[csv], section)
    with refused() as found:
        load_scenario(path)
    assert "\n" not in found.refusal
    assert found.refusal.startswith(f"{path}: {section}.file = ")
    assert "angle.csv" in found.refusal
    assert found.error.exit_code == 2


@pytest.mark.parametrize(
    "csv",
    [
        "t,a\n0,1\n1,x\n",
        "t,a\n0,1\n1,1_0\n",
    ],
)
def test_what_is_no_table_is_one_line(tmp_path, csv):
    """NumPy says why, other versions of it in other words."""
    path = scenario_with(tmp_path, csv)
    with pytest.raises(UserError) as caught:
        load_scenario(path)
    told = str(caught.value)
    assert told.startswith(f"{path}: reference.file = 'angle.csv': is not a table of numbers: ")
    assert "\n" not in told


def test_relative_csv_is_found_beside_the_scenario(tmp_path, monkeypatch):
    path = scenario_with(tmp_path, "t,a\n0,0\n1,0.04\n")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    (elsewhere / "angle.csv").write_text("t,a\n0,0\n1,99\n")
    assert at(load_scenario(path).reference, 0.5) == [0.02]


def test_trapezoidal_nowhere():
    move = Trapezoidal(distance=0.0, velocity=1.0, acceleration=1.0)
    assert at(move, 0.0, 1.0) == [0.0, 0.0]
    assert rate(move, 0.0, 1.0) == [0.0, 0.0]


def test_a_cubic_table_stands_still_where_its_rows_do(tmp_path):
    """A move of 3 mm between two rests: a cubic from rest to rest, x = 3 t^2 - 2 t^3 scaled."""
    path = tmp_path / "rest.csv"
    rows = [(0.0, 1.0), (0.5, 1.0), (1.0, 1.0), (3.0, 4.0), (3.5, 4.0 + 1e-12), (5.0, 4.0)]
    path.write_text("".join(f"{t},{x!r}\n" for t, x in rows))
    time = np.linspace(0.0, 5.0, 101)
    found = Table(file=path, interpolation="cubic").samples(time)
    rests = (time < 1.0) | (time >= 3.0)
    assert not found.reference_rate[rests].any()
    assert not found.reference_acceleration[rests].any()
    u = (time[~rests] - 1.0) / 2.0
    np.testing.assert_allclose(found.target[~rests], 1.0 + 9.0 * u**2 - 6.0 * u**3, rtol=1e-12)
    np.testing.assert_allclose(found.reference_rate[~rests], 9.0 * u - 9.0 * u**2, atol=1e-12)


def test_samples_in_time():
    simulation = Simulation(duration_s=0.3, sample_time_s=0.1)  # 0.3 / 0.1 is not quite 3
    assert simulation.steps == 3
    assert simulation.time.tolist() == pytest.approx([0.0, 0.1, 0.2])
