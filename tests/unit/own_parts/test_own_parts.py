"""A kind, a machine, a strategy and an objective of a user's own: everything, without a line here.

The oracle of the machine is SciPy's integrator, that of the exports the runtime, and that of the
runtime the toy kind's law written down once more with NumPy.
"""

import sys
from dataclasses import replace

import pytest
from click.testing import CliRunner
from places import OWN_PARTS

import hfc_design.api as hfc
from hfc_design.cli import main
from hfc_design.controllers.kinds import KINDS

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


def test_what_has_no_template_of_a_language_says_which(toy, tmp_path, monkeypatch):
    monkeypatch.setitem(KINDS.known, "toy", replace(toy.kind, st=None))
    with pytest.raises(hfc.UserError, match="kind toy: it has no template in Structured Text"):
        hfc.export(toy, "st", tmp_path / "out")
    hfc.export(toy, "c", tmp_path / "out")
