"""A fitness of your own: a small largest error with little change of the command.

In this folder::

    python 04_own_fitness.py [GENERATIONS]
    hfc design c-axis-ramp --controller pd --fitness 04_own_fitness:GENTLE
"""

import sys
from typing import Any

import jax.numpy as jnp

import hfc_design.api as hfc


def initial(zero: Any) -> Any:
    """Largest error, sum of the command's squared changes, last command; all zero at first."""
    return zero, zero, zero


def update(sums: Any, moments: tuple[hfc.Moment, ...], path: Any) -> Any:
    """One sample more. A moment has error, error_rate, deviation, command, reference_rate."""
    largest, roughness, last = sums
    (axis,) = moments  # two of them on an X-Y machine
    change = axis.command - last
    return jnp.maximum(largest, jnp.abs(axis.error)), roughness + change * change, axis.command


def score(sums: Any) -> Any:
    """The larger the better; a loop that diverges has no such number and ranks last."""
    largest, roughness, _ = sums
    return 1.0 / (1000.0 * largest + 0.001 * roughness)  # 1 mrad weighs as much as 1000 V2


GENTLE = hfc.Objective(initial, update, score, name="gentle", title="fitness, gentle")


def main(generations: int = 40) -> None:
    """Search a PD controller by eq. 5 of Lin & Lee (1999), and by the own fitness."""
    hfc.register(GENTLE)  # now a scenario can have fitness.kind = "gentle"
    wanted = {
        "search.generations": generations,
        "search.population": 64,
        "controller": {"kind": "pd"},
    }
    for kind in ("lin-lee", "gentle"):
        scenario = hfc.load_scenario("c-axis-ramp", {**wanted, "fitness": {"kind": kind}})
        found = hfc.design(scenario)
        gains, metrics = found.design.controller.pd, found.evaluation.metrics
        print(f"{kind}: kp {gains.kp:.4g}, kd {gains.kd:.4g}, ", end="")
        print(f"largest error {metrics['max_error_rad']:.3g} rad, ", end="")
        print(f"largest voltage {metrics['peak_voltage_V']:.3g} V")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
