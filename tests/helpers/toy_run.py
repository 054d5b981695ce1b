"""A run of the toy kind on the toy machine of tests/own_parts, but for what a command adds."""

import sys

import pytest
from known_parts import forget, made_known
from places import OWN_PARTS

import hfc_design.api as hfc
import hfc_design.runs.run as runs
from hfc_design.core.plugins import know

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
duration_s = 0.3
substeps = 2
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
population = 8
generations = 4
stick_penalty = 0.0
"""


@pytest.fixture(scope="module")
def toy_place(tmp_path_factory):
    """Of the run, and of its scenario."""
    place = tmp_path_factory.mktemp("own")
    sys.path.insert(0, str(OWN_PARTS))
    (place / "toy.toml").write_text(SCENARIO)
    groups = made_known()
    know([("plant", OWN[1]), ("controller", OWN[3])])
    runs.run(runs.new_run(hfc.load_scenario(place / "toy.toml"), place / "run"), place / "run")
    yield place
    forget(groups)
    sys.path.remove(str(OWN_PARTS))


@pytest.fixture
def toy_design(toy_place):
    return hfc.load_design(toy_place / "run")


@pytest.fixture
def toy(toy_design):
    """The part of the axis X."""
    return toy_design.by_axis()["x"]
