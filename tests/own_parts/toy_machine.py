"""A user's own machine: a carriage that carries a rotary table, two drives that push one another.

``hfc design SCENARIO --plant toy_machine:MACHINE``: a mass on a guide (x, in mm, driven in A) and a
table with a heavy eccentric part (c, in deg, driven in V). Where the table turns, its part pulls
at the carriage; where the carriage accelerates, it turns the table.
"""

from typing import Any, NamedTuple

import jax.numpy as jnp

import hfc_design.api as hfc


class Motion(NamedTuple):
    """State of either axis."""

    place: Any
    speed: Any


class Guide(NamedTuple):
    """The carriage."""

    mass: float = 20.0  # [kg]
    damping: float = 80.0  # [N s/m]
    force: float = 40.0  # [N/A]


class Table(NamedTuple):
    """The rotary table."""

    inertia: float = 0.4  # [kg m2]
    damping: float = 1.5  # [N m s/rad]
    torque: float = 2.0  # [N m/V]
    unbalance: float = 0.3  # of its part about the axis [kg m]


def _axis(name: str, parameters: Any, units: tuple[str, str, str], rate: Any) -> hfc.Drive:
    unit, command, load = units

    def step(p: Any, x: Motion, u: Any, loads: Any, dt: Any) -> Motion:
        return hfc.rk4(lambda y, force: Motion(y.speed, rate(p, y, u, force)), x, loads, dt)

    return hfc.Drive(
        name=name,
        parameters=parameters,
        fault=hfc.only_positive(parameters),
        units={
            "error": unit,
            "error_rate": f"{unit}/s",
            "command": command,
            "load": load,
            "speed": f"{unit}/s",
        },
        initial_state=lambda zero: Motion(zero, zero),
        step=step,
        signals=lambda p, x: {"speed": x.speed},
        position="place",
        velocity="speed",
        encoders={"place": "speed"},
    )


GUIDE = _axis(
    "toy-guide",
    Guide,
    ("mm", "A", "N"),
    lambda p, x, u, load: 1e3 * (p.force * u - load) / p.mass - p.damping * x.speed / p.mass,
)
TABLE = _axis(
    "toy-table",
    Table,
    ("deg", "V", "N m"),
    lambda p, x, u, load: (
        jnp.rad2deg(p.torque * u - load) / p.inertia - p.damping * x.speed / p.inertia
    ),
)


def forces(fixed: Any, states: Any, commands: Any) -> tuple[Any, Any]:
    """Load of the carriage [N] and of the table [N m] by the part that is off the axis."""
    guide, table = fixed
    angle, turning = jnp.deg2rad(states[1].place), jnp.deg2rad(states[1].speed)
    pulled = -table.unbalance * turning**2 * jnp.cos(angle)
    acceleration = guide.force * commands[0] / guide.mass  # [m/s2], without what resists
    return pulled, table.unbalance * acceleration * jnp.sin(angle)


MACHINE = hfc.coupled(hfc.side_by_side(x=GUIDE, c=TABLE), forces, name="toy-machine")
