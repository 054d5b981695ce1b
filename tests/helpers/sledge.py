"""A module with a plant, a law and a fitness of one's own, and what its tests call."""

import sys
from pathlib import Path

from click.testing import CliRunner

from hfc_design import api
from hfc_design.cli import main
from hfc_design.files.design import design_json

#: A mass under a force against viscous friction, m dv/dt = u - b v - load; a P law; a fitness.
MODULE = """
import math
from typing import Any, NamedTuple
import jax.numpy as jnp
import hfc_design.api as hfc

class Parameters(NamedTuple):
    mass: float = 2.0
    friction: float = 3.0

class State(NamedTuple):
    place: Any
    speed: Any

class Gains(NamedTuple):
    p: Any

def step(c, x, force, loads, dt):
    def rates(x, load):
        return State(x.speed, (force - c.friction * x.speed - load) / c.mass)
    return hfc.rk4(rates, x, loads, dt)

def sledge(**changes):
    return hfc.Plant(**dict(
        name="sledge",
        parameters=Parameters,
        fault=hfc.only_positive(Parameters),
        units={"error": "m", "error_rate": "m/s", "command": "N", "load": "N", "speed": "m/s"},
        initial_state=lambda zero: State(zero, zero),
        step=step,
        signals=lambda c, x: {"speed": x.speed},
        position="place",
        velocity="speed",
        encoders={"place": "speed"},
    ) | changes)

SLEDGE = sledge()
TAKEN = sledge(name="c-axis")
BAD_NAME = sledge(name="my sledge")
NO_UNIT = sledge(units={"error": "m", "error_rate": "m/s", "command": "N", "load": "N"})
NO_FIELD = sledge(position="angle")
OWN_ERROR = sledge(signals=lambda c, x: {"error": x.speed})
NO_DEFAULTS = sledge(parameters=NamedTuple("Bare", [("mass", float)]))

def branching(c, x, force, loads, dt):
    return x if force > 0.0 else step(c, x, force, loads, dt)

BRANCHING = sledge(step=branching)

def waving(c, x, force, loads, dt):
    return step(c, x, force * math.sin(x.place), loads, dt)

WAVING = sledge(step=waving)
SHRINKING = sledge(step=lambda c, x, force, loads, dt: (x.place, x.speed))

P = hfc.Law("only-p", Gains(p=(1.0, 100.0)), lambda zero: (),
            lambda T, gains, memory, signals: (gains.p * signals["error"], memory))
BLIND = P._replace(step=lambda T, gains, memory, signals: (signals["mood"], memory))
NO_RANGE = P._replace(ranges=Gains(p=(3.0, 1.0)))
NO_RECORD = P._replace(ranges={"p": (1.0, 3.0)})
LAST = hfc.Fitness(
    lambda zero: zero,
    lambda sums, moments, path: jnp.abs(moments[0].error),
    lambda sums: 1.0 / (0.001 + sums),
    name="last-error",
)
GROWING = LAST._replace(update=lambda sums, moments, path: (sums, sums))
FITNESS_TAKEN = LAST._replace(name="contour")
"""


SCENARIO = """
[plant]
name = "sledge"
[reference]
kind = "step"
height = 1.0
[simulation]
duration_s = 3.0
sample_time_s = 0.01
"""
CONTROLLER = '[controller]\nkind = "pd"\nranges = { kp = [1.0, 100.0], kd = [0.1, 10.0] }\n'
BUDGET = ("--population", "8", "--generations", "2", "--quiet")


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def refused(*arguments):
    """The one line that a command refuses with."""
    done = hfc(*arguments)
    assert done.exit_code == 2, done.output
    assert done.stderr.startswith("hfc: ")
    assert done.stderr.count("\n") == 1
    return done.stderr


def imported(name):
    sys.path.append(str(Path.cwd()))
    return __import__(name)


def scenario_of(kind):
    return {"controller": {"kind": kind}, "simulation": {"duration_s": 0.2}}


def installed(folder, *lines):
    """Make ``folder`` a place of installed packages, one of them with these entry points."""
    package(folder, *lines)
    sys.path.append(str(folder))


def package(folder, *lines):
    """What an installer leaves in ``folder`` of a package with these entry points."""
    info = folder / "sledges-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: sledges\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n")


def api_text(name):
    """A design file."""
    return design_json(api.load_design(name))
