"""Laps that learn, simulated: against lifted matrices, on machines of the tolerances, from logs."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.calls.laps import laps
from hfc_design.simulation.following import followed
from hfc_design.simulation.frequency import Setup
from hfc_design.simulation.laps import SLOW

#: A stage without friction, and a law without an integral: a linear loop.
LINEAR = {
    "plant.parameters.coulomb_friction": 0.0,
    "simulation.duration_s": 1.0,
    "reference.jerk": 20000.0,
}


@pytest.fixture(scope="module")
def stage():
    scenario = api.load_scenario("positioning-stage-move", LINEAR)
    return api.with_gains(scenario, "pd", {"kp": 3.0, "kd": 0.08}), scenario


def test_laps_of_a_linear_loop_are_those_of_lifted_matrices(stage):
    """Norm-optimal ILC in the time domain (Amann, Owens and Rogers), with no weight on the table.

    The matrix of the loop is made of its answer to one sample that is added to the command.
    """
    design, scenario = stage
    setup = Setup.of(design, scenario, None, 0.0, 0)
    steps = scenario.simulation.steps
    pulse = 0.01 * (np.arange(steps) == 0)
    answer = followed(setup, setup.machines, np.zeros(steps), pulse)[1][:, 0] / 0.01
    column = answer - answer[0]
    late = np.arange(steps)[:, None] - np.arange(steps)
    matrix = np.where(late >= 0, column[np.maximum(late, 0)], 0.0)
    made = laps(design, scenario=scenario, laps=4, machines=0)
    error, table = made.errors[0][0], np.zeros(steps)
    squares = matrix.T @ matrix
    wanted = [error]
    for _ in range(4):
        step = np.linalg.lstsq((1.0 + SLOW) * squares, matrix.T @ wanted[-1], rcond=1e-9)[0]
        table = table + step
        wanted.append(error - matrix @ table)
    rms = np.sqrt(np.mean(np.square(wanted), axis=1))
    np.testing.assert_allclose(made.rms[:5, 0], rms, rtol=0.1)


@pytest.mark.parametrize(
    ("design", "scenario", "smooth"),
    [
        (
            "huang-pid",
            "milling-table-circle",
            {"reference.jerk_mm_s3": 100.0, "shaper": {"kind": "zv", "hz": 20.0}},
        ),
        (
            "lin-gai-2009-pid",
            "five-axis-robust",
            {f"reference.limits.{axis}.jerk_per_s3": 20000.0 for axis in "xyzac"}
            | {"shaper": {"kind": "zv", "hz": 20.0}},
        ),
    ],
    ids=["milling table", "five axes"],
)
def test_smooth_learned_motion_is_better_on_a_thousand_machines(design, scenario, smooth):
    """The worst contour error of any machine, after five laps of its own."""
    plain = laps(design, scenario=scenario, laps=1, machines=1000)
    learned = laps(design, scenario=scenario, changes=smooth, laps=5, machines=1000)
    assert learned.worst[-1] <= 0.6 * plain.worst[0]
    assert np.isfinite(learned.largest).all()
    # A table of the nominal machine helps the others less, but never is it worse than none.
    assert learned.worst[-1] < learned.shared.max() < plain.worst[0]


def test_a_log_of_a_lap_gives_the_table_of_the_simulation(stage, tmp_path):
    """The motion of the simulator as a log: it begins later, and counts from another place."""
    design, scenario = stage
    evaluation = api.evaluate(design, scenario)
    (axis,) = evaluation.axes
    seen = axis.sensed()["error"]
    reference = np.asarray(axis.reference)
    rest = np.zeros(50)
    rows = [
        scenario.simulation.sample_time_s * np.arange(len(reference) + 50),
        np.hstack([rest, reference]) + 7.0,
        np.hstack([rest + seen[0], reference - seen]) + 7.0,
    ]
    head = "time [s],reference [mm],position [mm]"
    log = tmp_path / "lap.csv"
    np.savetxt(log, np.array(rows).T, delimiter=",", header=head, comments="", fmt="%.12g")
    from_log = laps(design, log, scenario=scenario)
    simulated = laps(design, scenario=scenario, laps=1, machines=0)
    assert from_log.rms[0, 0] == pytest.approx(simulated.rms[0, 0], rel=1e-3)
    scale = np.abs(simulated.table).max()
    np.testing.assert_allclose(from_log.table, simulated.table, atol=0.01 * scale)
