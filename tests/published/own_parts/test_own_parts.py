"""A kind, a machine, a strategy and an objective of a user's own: everything, without a line here.

The oracle of the machine is SciPy's integrator, that of the exports the runtime, and that of the
runtime the toy kind's law written down once more with NumPy.
"""

import sys

import numpy as np
import pytest
from click.testing import CliRunner
from places import OWN_PARTS

import hfc_design.api as hfc
from hfc_design import runtime
from hfc_design.cli import main

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


def test_who_lacks_it_is_told_what_to_add(folder, tmp_path):
    """In a process that has never heard of it."""
    import subprocess

    found = subprocess.run(
        [sys.executable, "-m", "hfc_design", "score", folder / "run"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert found.returncode == 2
    assert "its provenance names --use toy_machine:MACHINE --use toy_kind:KIND" in found.stderr
