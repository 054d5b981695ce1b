"""A kind, a machine, a strategy and an objective of a user's own: everything, without a line here.

The oracle of the machine is SciPy's integrator, and that of the runtime the toy kind's law written
down once more with NumPy.
"""

import shutil
import zipfile

import numpy as np
import pytest
from run_folders import ran
from scipy.integrate import solve_ivp
from toy_run import OWN

import hfc_design.api as hfc
import hfc_design.runs.run as runs
from hfc_design import runtime


def table_by_hand(record, errors, limit):
    """The toy kind's commands to errors in turn."""
    heights, total, found = np.array(record.heights), 0.0, []
    for error in errors:
        place = np.clip(error / record.width, -2.0, 2.0)
        weights = np.maximum(1.0 - np.abs(place - np.arange(-2, 3)), 0.0)
        inferred = np.interp(place, np.arange(-2, 3), heights)
        step = record.integral * 0.001 * error
        if not (abs(inferred + total + step) > limit and step * (inferred + total + step) > 0):
            total += step
        found.append(np.clip(inferred + total, -limit, limit))
        heights = heights + record.rate * weights * error
    return np.array(found)


def test_the_runtime_steps_it(toy):
    errors = 6.0 * np.sin(0.05 * np.arange(400))
    controller = runtime.Controller(toy)
    found = np.array([controller.step({"error": error}) for error in errors])
    expected = table_by_hand(toy.controller, errors, 4.0)
    assert np.abs(expected).max() == 4.0 < np.abs(errors).max()  # its limit holds
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    learnt = controller.adapted()
    assert learnt.heights != toy.controller.heights
    assert type(learnt).model_validate(learnt.model_dump()) == learnt  # a table that can be saved


def test_both_axes_are_exported(toy_place, tmp_path):
    ran("export", toy_place / "run", *OWN, "--to", "c", "--bare", "--out", tmp_path / "c")
    assert sorted(path.name for path in (tmp_path / "c").glob("*/*.c")) == ["toy_c.c", "toy_x.c"]
    assert "_real error_rate; /* [deg/s] */" in (tmp_path / "c" / "c" / "toy_c.h").read_text()
    assert "_real error; /* [mm] */" in (tmp_path / "c" / "x" / "toy_x.h").read_text()
    ran("export", toy_place / "run", *OWN, "--to", "st", "--out", tmp_path / "st")
    names = sorted(path.name for path in (tmp_path / "st").iterdir())
    assert names == ["README.md", "c", "x"]
    assert (tmp_path / "st" / "x" / "toy_x.st").exists()


def test_the_simulator_does_what_the_runtime_does(toy_design, toy_place):
    scenario = hfc.load_scenario(toy_place / "run" / "config.toml")
    found = hfc.evaluate(toy_design, scenario)
    machine = runtime.Machine(toy_design)
    told = {axis.name: axis.sensed() for axis in found.axes}
    for k in range(scenario.simulation.steps):
        signals = {
            name: {key: value[k] for key, value in own.items()} for name, own in told.items()
        }
        command = machine.step(signals)
        for axis in found.axes:
            assert command[axis.name] == pytest.approx(axis.motion.command[k], rel=1e-12, abs=1e-13)


def integrated(found):
    """Where both axes end by SciPy, under the recorded commands, pushed at every instant."""
    x, c = found.axes
    guide, table = (axis.parameters for axis in found.axes)

    def rates(t, y, amps, volts):
        angle, turning = np.radians(y[2]), np.radians(y[3])
        pulled = -table.unbalance * turning**2 * np.cos(angle)
        twisted = table.unbalance * guide.force * amps / guide.mass * np.sin(angle)
        moved = 1e3 * (guide.force * amps - pulled) / guide.mass
        turned = np.degrees(table.torque * volts - twisted) / table.inertia
        return [
            y[1],
            moved - guide.damping * y[1] / guide.mass,
            y[3],
            turned - table.damping * y[3] / table.inertia,
        ]

    y = np.zeros(4)
    for pair in zip(x.motion.command[:-1], c.motion.command[:-1], strict=True):
        y = solve_ivp(rates, (0.0, 0.001), y, args=pair, rtol=1e-11, atol=1e-13).y[:, -1]
    return y[[0, 2]]


def test_the_machine_moves_as_scipy_says(toy_design, toy_place):
    off, ended = {}, {}
    for substeps in (2, 4):
        changes = {"simulation.substeps": substeps}
        scenario = hfc.load_scenario(toy_place / "run" / "config.toml", changes)
        found = hfc.evaluate(toy_design, scenario)
        ends = np.array([axis.motion.state.place[-1] for axis in found.axes])
        off[substeps] = np.abs(ends - integrated(found))
        ended[substeps] = ends
        assert found.axes[1].parameters.inertia == 0.5  # of the scenario
    assert off[2].max() < 1e-4  # mm, deg
    assert (off[4] < off[2] / 3.0).all()  # of second order
    apart = hfc.load_scenario(
        toy_place / "run" / "config.toml", {**changes, "plant.axes.c.unbalance": 1e-12}
    )
    alone = hfc.evaluate(toy_design, apart)
    ends = np.array([axis.motion.state.place[-1] for axis in alone.axes])
    assert (np.abs(ends - ended[4]) > 100.0 * off[2]).all()  # they do push one another


def test_stopped_and_resumed_ends_alike(toy_place, tmp_path):
    scenario = runs.opened_run(toy_place / "run")

    class Stop(Exception):
        pass

    def stop(search):
        if search.generation == 2:
            raise Stop

    shutil.copytree(toy_place / "run", tmp_path / "run")
    for name in ("design.json", "checkpoint.npz", "history.csv"):
        (tmp_path / "run" / name).unlink()
    with pytest.raises(Stop):
        runs.run(scenario, tmp_path / "run", stop)
    runs.run(scenario, tmp_path / "run")
    for name in ("design.json", "checkpoint.npz", "history.csv"):
        assert (tmp_path / "run" / name).read_bytes() == (toy_place / "run" / name).read_bytes()


def test_each_axis_is_a_component_of_its_own(toy_place, tmp_path):
    ran("export", toy_place / "run", *OWN, "--to", "linuxcnc", "--out", tmp_path / "hal")
    for axis in "xc":
        assert (tmp_path / "hal" / axis / f"hfc_toy_{axis}.comp").exists()
        assert (tmp_path / "hal" / axis / "loop.hal").exists()


def test_a_machine_whose_axes_push_one_another_is_a_model(toy_place, tmp_path):
    for to in ("fmu-plant", "fmu-loop"):
        ran("export", toy_place / "run", *OWN, "--to", to, "--out", tmp_path / to)
        with zipfile.ZipFile(next((tmp_path / to).glob("*fmi3.fmu"))) as archive:
            assert "sources/plant_toy_machine_step.c" in archive.namelist()
