"""An own drive with fast friction in plain RK4 steps says up to which speed they are stable."""

from typing import Any, NamedTuple

import pytest

import hfc_design.api as hfc
from hfc_design.core.records import UserError
from plants.blocks import LuGre, bristle, friction_torque

PERIOD = 1e-3


class Parameters(NamedTuple):
    mass: float = 20.0  # [kg]
    bristle_stiffness: float = 3e5  # [N/m]
    coulomb: float = 30.0  # [N]


class State(NamedTuple):
    place: Any  # [m]
    speed: Any  # [m/s]
    bristle: Any  # [m]


def step(p, x, force, loads, dt):
    friction = LuGre(p.bristle_stiffness, 500.0, 10.0, p.coulomb, 0.0, 1000.0)

    def rates(x, load):
        bent, rate = bristle(friction, x.speed, x.bristle)
        resists = friction_torque(friction, x.speed, bent, rate)
        return State(x.speed, (force - resists - load) / p.mass, rate)

    return hfc.rk4(rates, x, loads, dt)


SLIDE = hfc.Plant(
    name="slide",
    parameters=Parameters,
    fault=hfc.only_positive(Parameters),
    units={"error": "m", "error_rate": "m/s", "command": "N", "load": "N"},
    initial_state=lambda zero: State(zero, zero, zero),
    step=step,
    signals=lambda p, x: {},
    position="place",
    velocity="speed",
    encoders={"place": "speed"},
    # The bristles decay with speed bristle_stiffness / coulomb; RK4 is stable to 2.785 / dt.
    fastest=lambda p, dt: 2.785 * p.coulomb / (p.bristle_stiffness * dt),
)


@pytest.fixture
def slide(own_plugins):
    return hfc.register(SLIDE)


def scenario(speed, **simulation):
    return {
        "plant": {"name": "slide"},
        "reference": {"kind": "ramp", "velocity": speed},
        "simulation": {"duration_s": 0.2, **simulation},
        "controller": {"kind": "pd", "ranges": {"kp": [1.0, 1e5], "kd": [1.0, 1e4]}},
    }


def test_machines_of_a_spread_need_steps_of_their_own(slide):
    limit = SLIDE.fastest(Parameters(), PERIOD)
    found = hfc.load_scenario(scenario(0.99 * limit))
    design = hfc.with_gains(found, "pd", {"kp": 1e4, "kd": 2e3})
    with pytest.raises(UserError, match=r"simulation.substeps = 1: some of these .* at least 2"):
        hfc.robustness(design, found, 0.2, 20)
