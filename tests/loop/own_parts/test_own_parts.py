"""A kind, a machine, a strategy and an objective of a user's own: everything, without a line here.

The oracle of the machine is SciPy's integrator, that of the exports the runtime, and that of the
runtime the toy kind's law written down once more with NumPy.
"""

import json
import shutil
import sys

import numpy as np
import pytest
from click.testing import CliRunner
from places import OWN_PARTS
from scipy.integrate import solve_ivp

import hfc_design.api as hfc
from hfc_design import runtime
from hfc_design.cli import main
from hfc_design.report.errors import errors

HERE = OWN_PARTS
OWN = ("--plant", "toy_machine:MACHINE", "--use", "toy_kind:KIND")
SCENARIO = """
[plant]
name = "toy-machine"
[plant.axes.c]
inertia = 0.5
[reference]
kind = "per-axis"
[reference.axes.x]
kind = "trapezoidal"
distance = 50.0
velocity = 100.0
acceleration = 500.0
[reference.axes.c]
kind = "sine"
amplitude = 30.0
frequency_rad_s = 4.0
[simulation]
duration_s = 0.5
[limits.axes.x]
command = 4.0
[controller]
kind = "per-axis"
[controller.axes.x]
kind = "toy"
width = 2.0
largest = 8.0
integral = 30.0
rate = 0.01
[controller.axes.c]
kind = "pd"
ranges = { kp = [0.1, 20.0], kd = [0.001, 0.2] }
[search]
population = 24
generations = 6
stick_penalty = 0.0
"""


def ran(*arguments):
    found = CliRunner().invoke(main, [str(item) for item in arguments])
    assert found.exit_code == 0, found.output
    return found.output


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run of the toy kind on the toy machine, as the command line makes it."""
    place = tmp_path_factory.mktemp("own")
    sys.path.insert(0, str(HERE))
    (place / "toy.toml").write_text(SCENARIO)
    ran("design", place / "toy.toml", *OWN, "--out", place / "run", "--quiet")
    yield place
    sys.path.remove(str(HERE))


@pytest.fixture
def design(folder):
    return hfc.load_design(folder / "run")


@pytest.fixture
def toy(design):
    """The part of the axis X."""
    return design.by_axis()["x"]


def test_both_axes_are_exported(folder, tmp_path):
    ran("export", folder / "run", *OWN, "--to", "c", "--out", tmp_path / "c")
    assert sorted(path.name for path in (tmp_path / "c").glob("*/*.c")) == ["toy_c.c", "toy_x.c"]
    assert "_real error_rate; /* [deg/s] */" in (tmp_path / "c" / "c" / "toy_c.h").read_text()
    assert "_real error; /* [mm] */" in (tmp_path / "c" / "x" / "toy_x.h").read_text()
    ran("export", folder / "run", *OWN, "--to", "st", "--out", tmp_path / "st")
    names = sorted(path.name for path in (tmp_path / "st").iterdir())
    assert names == ["README.md", "c", "x"]
    assert (tmp_path / "st" / "x" / "toy_x.st").exists()


def test_the_simulator_does_what_the_runtime_does(design, folder):
    scenario = hfc.load_scenario(folder / "run" / "config.toml")
    found = hfc.evaluate(design, scenario)
    machine = runtime.Machine(design)
    told = {axis.name: axis.told() for axis in found.axes}
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


def test_the_machine_moves_as_scipy_says(design, folder):
    off, ended = {}, {}
    for substeps in (2, 4):
        changes = {"simulation.substeps": substeps, "simulation.duration_s": 0.3}
        scenario = hfc.load_scenario(folder / "run" / "config.toml", changes)
        found = hfc.evaluate(design, scenario)
        ends = np.array([axis.motion.state.place[-1] for axis in found.axes])
        off[substeps] = np.abs(ends - integrated(found))
        ended[substeps] = ends
        assert found.axes[1].parameters.inertia == 0.5  # of the scenario
    assert off[2].max() < 1e-4  # mm, deg
    assert (off[4] < off[2] / 3.0).all()  # of second order
    apart = hfc.load_scenario(
        folder / "run" / "config.toml", {**changes, "plant.axes.c.unbalance": 1e-12}
    )
    alone = hfc.evaluate(design, apart)
    ends = np.array([axis.motion.state.place[-1] for axis in alone.axes])
    assert (np.abs(ends - ended[4]) > 100.0 * off[2]).all()  # they do push one another


def test_stopped_and_resumed_ends_alike(folder, tmp_path):
    import hfc_design.runs.run as runs

    scenario = runs.opened_run(folder / "run")

    class Stop(Exception):
        pass

    def stop(search):
        if search.generation == 3:
            raise Stop

    shutil.copytree(folder / "run", tmp_path / "run")
    for name in ("design.json", "checkpoint.npz", "history.csv", "report.html"):
        (tmp_path / "run" / name).unlink()
    with pytest.raises(Stop):
        runs.run(scenario, tmp_path / "run", stop)
    ran("design", "--resume", "--out", tmp_path / "run", *OWN, "--quiet")
    for name in ("design.json", "checkpoint.npz", "history.csv"):
        assert (tmp_path / "run" / name).read_bytes() == (folder / "run" / name).read_bytes()


def test_what_has_no_component_is_refused_and_leaves_nothing(folder, tmp_path):
    out = tmp_path / "hal"
    arguments = ["export", folder / "run", *OWN, "--to", "linuxcnc", "--out", out]
    refused = CliRunner().invoke(main, [str(item) for item in arguments])
    assert refused.exit_code == 2
    assert "HAL has no component of the plant toy-machine" in refused.output
    assert not out.exists()


def test_axes_of_other_units_have_an_error_each(folder):
    evaluation = hfc.evaluate(folder / "run", folder / "run" / "config.toml")
    panels = errors({"this design": evaluation}).axes
    assert [axes.get_ylabel() for axes in panels] == [
        "largest x error [mm]",
        "largest c error [deg]",
    ]
    for axes, axis in zip(panels, evaluation.axes, strict=True):
        (line,) = axes.lines
        assert max(line.get_ydata()) == np.abs(axis.motion.error).max()


def test_it_is_explained_and_reported(folder, tmp_path):
    page = (folder / "run" / "report.html").read_text()
    assert "x: A table of its own" in page
    assert "The learnt table." in page
    design = hfc.load_design(folder / "run")
    single = design.by_axis()["x"].model_dump(mode="json")
    assert single["limits"]["command"] == 4.0
    arguments = ["explain", str(folder / "run"), *OWN, "--at", "error=1.0"]
    assert "--axis: is missing, one has to be named" in CliRunner().invoke(main, arguments).output
    told = ran("explain", folder / "run", *OWN, "--axis", "x", "--at", "error=1.0", "--json")
    assert {"units", "parts", "command"} <= json.loads(told).keys()
    assert "toy" in ran("list", "controllers", *OWN)
