"""A machine of your own: a carriage (x, mm) and a rotary table on it (c, deg) push one another.

The table has a heavy part off its axis: when the table turns, this part pulls at the carriage;
when the carriage accelerates, it turns the table. In this folder::

    python 05_own_machine.py [GENERATIONS]
    hfc design turning_table.toml --plant 05_own_machine:MACHINE
"""

import sys
from pathlib import Path
from typing import Any, NamedTuple

import jax.numpy as jnp

import hfc_design.api as hfc


class Motion(NamedTuple):
    """State of either axis, in its unit."""

    place: Any
    speed: Any


class Carriage(NamedTuple):
    """Parameters of the carriage."""

    mass: float = 20.0  # with the table [kg]
    damping: float = 80.0  # [N s/m]
    force: float = 40.0  # [N/A]


class Table(NamedTuple):
    """Parameters of the table."""

    inertia: float = 0.4  # [kg m2]
    damping: float = 1.5  # [N m s/rad]
    torque: float = 2.0  # [N m/V]
    unbalance: float = 0.3  # of its part about the axis [kg m]


def drive(name: str, parameters: Any, units: tuple[str, str, str], rate: Any) -> hfc.Drive:
    """One axis; ``rate`` is its acceleration, in its unit."""
    unit, command, load = units

    def step(p: Any, x: Motion, u: Any, loads: Any, dt: Any) -> Motion:
        return hfc.rk4(lambda y, force: Motion(y.speed, rate(p, y, u, force)), x, loads, dt)

    rate_unit = f"{unit}/s"
    known = {"error": unit, "error_rate": rate_unit, "command": command, "load": load}
    return hfc.Drive(
        name=name,
        parameters=parameters,
        fault=hfc.only_positive(parameters),
        units={**known, "speed": rate_unit},
        initial_state=lambda zero: Motion(zero, zero),
        step=step,
        signals=lambda p, x: {"speed": x.speed},
        position="place",
        velocity="speed",
        encoders={"place": "speed"},
    )


def carried(p: Carriage, x: Motion, amps: Any, load: Any) -> Any:
    """Acceleration of the carriage [mm/s2]; ``load`` in N."""
    return (1e3 * (p.force * amps - load) - p.damping * x.speed) / p.mass


def turned(p: Table, x: Motion, volts: Any, load: Any) -> Any:
    """Acceleration of the table [deg/s2]; ``load`` in N m."""
    return (jnp.rad2deg(p.torque * volts - load) - p.damping * x.speed) / p.inertia


def forces(fixed: Any, states: Any, commands: Any) -> tuple[Any, Any]:
    """What each axis adds to the load of the other: on the carriage [N], on the table [N m]."""
    carriage, table = fixed
    angle, turning = jnp.deg2rad(states[1].place), jnp.deg2rad(states[1].speed)
    acceleration = carriage.force * commands[0] / carriage.mass  # [m/s2], but for what resists
    pulled = -table.unbalance * turning**2 * jnp.cos(angle)
    return pulled, table.unbalance * acceleration * jnp.sin(angle)


MACHINE = hfc.coupled(
    hfc.side_by_side(
        x=drive("carriage", Carriage, ("mm", "A", "N"), carried),
        c=drive("table", Table, ("deg", "V", "N m"), turned),
    ),
    forces,
    name="turning-table",
)


def main(generations: int = 30) -> None:
    """Search PD gains for each axis, on the machine as it is and with ten times the unbalance."""
    hfc.register(MACHINE)
    file = Path(__file__).with_name("turning_table.toml")
    for unbalance in (0.3, 3.0):
        changes = {"search.generations": generations, "plant.axes.c.unbalance": unbalance}
        found = hfc.design(hfc.load_scenario(file, changes)).evaluation.metrics
        print(
            f"unbalance {unbalance:g} kg m: rms error {found['x_rms_error_mm']:.4f} mm, "
            f"{found['c_rms_error_deg']:.3f} deg; peak current {found['x_peak_current_A']:.2f} A"
        )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
