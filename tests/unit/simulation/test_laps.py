"""Laps that learn, without a simulation: the filters, which lap is kept, logs, tables and files."""

import numpy as np
import pytest
from wording import refused_command

from hfc_design.calls.laps import _aligned, _error
from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.laps import FADING, Laps
from hfc_design.simulation.laps import Filters, Kept, largest_error

STEPS = 400


def filters(gain=0.5, limit=10.0, axes=2):
    length = 1024
    even = np.ones((axes, length // 2 + 1))
    return Filters(even, gain * even, np.full((axes, 1), limit), (50.0,) * axes, length)


def test_a_loop_of_gain_2_is_learned_by_halves():
    """Half of the inverse of the gain takes half of the error away in each lap."""
    disturbance = np.random.default_rng(1).standard_normal((2, STEPS))
    own, table, kept = filters(0.25), np.zeros((2, STEPS)), None
    for lap in range(4):
        error = disturbance - 2.0 * table
        np.testing.assert_allclose(error, 0.5**lap * disturbance, atol=1e-12)
        kept = Kept.of(table, error) if kept is None else kept.after(table, error)
        table = kept.following(own)


def test_a_worse_lap_is_not_learned_from_and_halves_the_steps_of_its_axis():
    first = Kept.of(np.zeros((2, 4)), np.ones((2, 4)))
    worse = np.array([[2.0] * 4, [0.5] * 4])
    kept = first.after(np.ones((2, 4)), worse)
    assert kept.gain.tolist() == [0.5, 1.0]
    assert kept.size.tolist() == [1.0, 0.5]
    assert kept.table[:, 0].tolist() == [0.0, 1.0]
    never = first.after(np.ones((2, 4)), np.full((2, 4), np.nan))  # diverged
    assert never.size.tolist() == [1.0, 1.0]


def test_a_table_stays_within_the_limits():
    table = Kept.of(np.zeros((2, STEPS)), np.full((2, STEPS), 100.0)).following(filters())
    assert np.abs(table).max() <= 10.0


@pytest.fixture(scope="module")
def circle():
    scenario = load_scenario("milling-table-circle", {"simulation.duration_s": 2.0})
    return scenario, scenario.samples()


def log_of(folder, circle, before=30, off=(100.0, -7.0), error=None, share=1.0):
    """A log that begins early, and counts from another place."""
    scenario, samples = circle
    path = np.array([np.asarray(one.reference) for one in samples.axes])
    whole = share * np.hstack([path[:, [0] * before], path, path[:, [-1] * 20]])
    wrong = np.zeros_like(whole)
    wrong[:, before : before + path.shape[1]] = 0.0 if error is None else error
    reference = whole + np.array(off)[:, None]
    rows = [scenario.simulation.sample_time_s * np.arange(whole.shape[1])]
    rows += [*reference, *(reference - wrong)]
    head = "time [s],x_reference [mm],y_reference [mm],x [mm],y_position [mm]"
    file = folder / "lap.csv"
    np.savetxt(file, np.array(rows).T, delimiter=",", header=head, comments="", fmt="%.12g")
    return file


def test_the_error_of_a_log_is_found_wherever_its_motion_begins(tmp_path, circle):
    wrong = 1e-3 * np.random.default_rng(2).standard_normal((2, len(circle[1].time)))
    found = _error(log_of(tmp_path, circle, error=wrong), *circle, (), None)
    np.testing.assert_allclose(found, wrong, atol=1e-9)


def test_a_log_of_another_motion_is_refused(tmp_path, circle):
    with pytest.raises(ValueError, match="reference: must be that of the scenario"):
        _error(log_of(tmp_path, circle, share=0.8), *circle, (), None)


def test_a_short_log_is_refused_in_a_line(tmp_path, circle):
    file = log_of(tmp_path, circle)
    lines = file.read_text().splitlines()
    file.write_text("\n".join(lines[:200]) + "\n")
    with pytest.raises(ValueError, match="must contain the whole motion of 2 s"):
        _error(file, *circle, (), None)


@pytest.mark.parametrize(
    ("before", "change"),
    [
        ("x_reference [mm]", "elsewhere [mm]"),  # no reference
        ("time [s]", "number [1]"),  # no time
        ("y_position [mm]", "y_position [kg]"),
    ],
)
def test_a_log_that_lacks_a_signal_is_refused_before_any_simulation(
    tmp_path, circle, before, change, monkeypatch
):
    file = log_of(tmp_path, circle)
    file.write_text(file.read_text().replace(before, change, 1))
    monkeypatch.chdir(tmp_path)
    known = ("--set", "simulation.duration_s=2", "--scenario", "milling-table-circle")
    refused_command("laps", "huang-pid", file.name, *known)


def test_what_laps_cannot_do_is_refused_in_a_line():
    refused_command("laps", "huang-pid", "--motion", "second")
    refused_command("laps", "huang-pid", "--laps", 0)
    refused_command("laps", "huang-pid", "missing.csv")


def test_signals_are_aligned_where_they_differ_least():
    wanted = np.random.default_rng(3).standard_normal((1, 50)).cumsum(axis=1)
    logged = np.hstack([np.zeros((1, 17)), wanted, np.ones((1, 9))]) + 1e3
    assert _aligned(logged, wanted) == 17


def test_contour_errors_of_a_circle_are_distances_from_it(circle):
    """By hand: a circle of 60 mm about (-60, 0), and the machine is 0.1 mm outside everywhere."""
    scenario, samples = circle
    target = np.array([np.asarray(one.target) for one in samples.axes])
    centre = np.array([[-scenario.path.radius_mm], [0.0]])
    away = target - centre
    off = 0.1 * away / np.hypot(*away)
    assert largest_error(samples, off[None]) == pytest.approx([0.1], abs=1e-9)


def made(circle, logs=False):
    scenario, samples = circle
    steps = len(samples.time)
    table = np.sin(np.arange(2.0 * steps).reshape(2, steps))
    largest = np.array([[4.0, 6.0, 5.0], [2.0, 3.0, np.nan], [1.0, 2.0, np.nan]])
    names = ("a.csv", "b.csv", "c.csv") if logs else ("0", "1", "kept")
    shared = None if logs else np.array([1.0, 3.0, 4.0])
    largest = largest[:, :1] if logs else largest
    known = (scenario, filters(), names, 0.5 * largest, largest, shared)
    return Laps("huang-pid", *known, table, 0.5 * table, (table, 0.1 * table))


def test_the_table_has_a_row_for_each_lap(circle):
    (table,) = made(circle).tables()
    assert [row[0] for row in table.rows] == ["0", "1", "kept"]
    assert table.rows[0][1:] == ["2", "4", "5", "6"]
    assert table.rows[2][-1] == "2"
    assert "1 of 3 machines diverge, and do not count" in table.lines
    numbers = made(circle).numbers()
    assert numbers["laps"][1] | {"diverged": 1, "worst": 3.0} == numbers["laps"][1]
    assert numbers["one_table_for_all"] == 4.0
    (logged,) = made(circle, logs=True).tables()
    assert len(logged.head) == 3
    made(circle).figure()


def test_the_files_hold_the_table(tmp_path, circle):
    laps = made(circle)
    laps.write(tmp_path / "out")
    rows = np.loadtxt(tmp_path / "out" / "laps.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, 1:].T, laps.table, atol=1e-8)
    best = np.loadtxt(tmp_path / "out" / "best.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(best[:, 1:], 0.5 * rows[:, 1:], atol=1e-8)
    streamed = np.loadtxt(tmp_path / "out" / "laps.txt")
    assert len(streamed) == len(rows) + FADING
    assert streamed[-1].tolist() == [0.0, 0.0]
    header = (tmp_path / "out" / "laps.h").read_text()
    assert f"#define LAPS_SAMPLES {len(rows)}" in header
    assert "laps_y[LAPS_SAMPLES]" in header
    hal = (tmp_path / "out" / "laps.hal").read_text()
    assert "loadrt sum2 names=laps-x,laps-y" in hal
