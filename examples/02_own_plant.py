"""A plant of your own: a table on a belt, and a fuzzy hierarchy designed for it.

In this folder::

    python 02_own_plant.py [GENERATIONS]
    hfc design belt_table.toml --plant 02_own_plant:TABLE
"""

import sys
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import jax.numpy as jnp

import hfc_design.api as hfc


class Parameters(NamedTuple):
    """The defaults are the nominal machine."""

    motor_mass: Annotated[float, "kg"] = 2.0  # of motor and pulley, as felt by the belt
    table_mass: Annotated[float, "kg"] = 8.0
    stiffness: Annotated[float, "N/m"] = 40_000.0  # of the belt
    damping: Annotated[float, "N s/m"] = 60.0  # of the belt
    friction: Annotated[float, "N"] = 6.0  # of the table's guide
    force_constant: Annotated[float, "N/A"] = 12.0


class State(NamedTuple):
    """Every field is a scalar: the simulator makes a population of it."""

    motor: Any  # [m]
    motor_velocity: Any  # [m/s]
    table: Any  # [m]
    table_velocity: Any  # [m/s]


def derivative(p: Parameters, x: State, current: Any, load: Any) -> State:
    """Rates of the state; jnp instead of math, jnp.where instead of if."""
    stretch_rate = x.motor_velocity - x.table_velocity
    belt = p.stiffness * (x.motor - x.table) + p.damping * stretch_rate
    friction = p.friction * jnp.tanh(x.table_velocity / 0.001)
    return State(
        motor=x.motor_velocity,
        motor_velocity=(p.force_constant * current - belt) / p.motor_mass,
        table=x.table_velocity,
        table_velocity=(belt - friction - load) / p.table_mass,
    )


def step(p: Parameters, x: State, current: Any, loads: Any, dt: Any) -> State:
    """The state ``dt`` [s] later under a constant current."""
    return hfc.rk4(lambda state, load: derivative(p, state, current, load), x, loads, dt)


TABLE = hfc.Plant(
    name="belt-table",
    parameters=Parameters,
    fault=hfc.only_positive(Parameters),
    units={
        "error": "m",
        "error_rate": "m/s",
        "command": "A",
        "load": "N",
        "stretch": "m",
        "table_velocity": "m/s",
    },
    initial_state=lambda zero: State(zero, zero, zero, zero),
    step=step,
    signals=lambda p, x: {"stretch": x.motor - x.table, "table_velocity": x.table_velocity},
    position="table",
    velocity="table_velocity",
    encoders={"motor": "motor_velocity", "table": "table_velocity"},
)


def main(generations: int = 60) -> None:
    """Design a hierarchy for the table, and a PD controller to compare with."""
    hfc.register(TABLE)  # from now on a scenario can name the plant "belt-table"
    file = Path(__file__).with_name("belt_table.toml")
    scenario = hfc.load_scenario(file, {"search.generations": generations})
    fuzzy = hfc.design(scenario).evaluation
    pd = {"controller": {"kind": "pd", "ranges": {"kp": [1e2, 1e5], "kd": [1.0, 1e4]}}}
    alone = hfc.design(hfc.load_scenario(file, {"search.generations": generations, **pd}))
    for name, found in {"fuzzy hierarchy": fuzzy, "best PD": alone.evaluation}.items():
        print(f"{name}: largest error {1e6 * found.metrics['max_error_m']:.0f} um")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
