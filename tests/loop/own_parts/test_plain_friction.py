"""An own drive with fast friction in plain RK4 steps says up to which speed they are stable."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import pytest
from wording import refused

import hfc_design.api as hfc
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


def test_the_speed_that_it_says_is_where_its_steps_stop_being_stable():
    """A bristle that is off its steady deflection comes back to it, or does not."""
    limit = SLIDE.fastest(Parameters(), PERIOD)
    heavy = Parameters(mass=1e9)  # its speed stays

    def sample(_, x):
        return step(heavy, x, 0.0, (0.0, 0.0, 0.0), PERIOD)

    def off(speed):
        with jax.enable_x64(True):
            start = jax.tree.map(jnp.float64, State(0.0, speed, 1.01e-4))
            return abs(jax.lax.fori_loop(0, 100, sample, start).bristle / 1e-4 - 1)

    assert off(0.98 * limit) < 1e-4
    assert off(1.02 * limit) > 10.0


def test_a_faster_motion_needs_finer_steps(slide):
    limit = SLIDE.fastest(Parameters(), PERIOD)
    found = hfc.load_scenario(scenario(3.5 * limit, substeps=4))
    design = hfc.with_gains(found, "pd", {"kp": 1e4, "kd": 2e3})
    assert not hfc.evaluate(design, found).diverged
    with refused() as told:
        hfc.load_scenario(scenario(3.5 * limit, substeps=2))
    assert "simulation.substeps = " in told.refusal


def test_machines_of_a_spread_need_steps_of_their_own(slide):
    limit = SLIDE.fastest(Parameters(), PERIOD)
    found = hfc.load_scenario(scenario(0.99 * limit))
    design = hfc.with_gains(found, "pd", {"kp": 1e4, "kd": 2e3})
    with refused() as told:
        hfc.robustness(design, found, 0.2, 20)
    assert "simulation.substeps = " in told.refusal
