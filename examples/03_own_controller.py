"""A control law of your own: a PI position loop around a P velocity loop, with searched gains.

In this folder::

    python 03_own_controller.py [GENERATIONS]
    hfc design feed-drive-line --controller 03_own_controller:CASCADE
"""

import sys
from typing import Any, NamedTuple

import jax.numpy as jnp

import hfc_design.api as hfc


class Gains(NamedTuple):
    """What is searched."""

    position: Any  # [1/s]
    integral: Any  # [1/s2]
    velocity: Any  # [units/(BLU/s)]


def step(sample_time: float, gains: Gains, total: Any, signals: dict[str, Any]) -> Any:
    """Command and what to remember, from what was remembered and what is measured.

    ``signals`` has error, error_rate and what the plant reports; see ``hfc list plants``.
    """
    total = total + sample_time * signals["error"]
    total = jnp.clip(total, -5.0, 5.0)  # [BLU s] anti-windup
    wanted = signals["velocity"] + signals["error_rate"]  # velocity of the reference
    wanted = wanted + gains.position * signals["error"] + gains.integral * total
    return gains.velocity * (wanted - signals["velocity"]), total


CASCADE = hfc.Law(
    name="cascade",
    # A range above zero is searched by its logarithm, any other one on a straight line.
    ranges=Gains(position=(1.0, 100.0), integral=(0.0, 500.0), velocity=(0.01, 1.0)),
    initial_memory=lambda zero: zero,
    step=step,
)


def main(generations: int = 40) -> None:
    """Search the own law and the built-in PID, and compare them with the published PID."""
    hfc.register(CASCADE)  # now a scenario and a design file can name the kind "cascade"
    wanted = {"search.generations": generations, "search.population": 64}
    rows = {}
    for kind in ("cascade", "pid"):
        scenario = hfc.load_scenario("feed-drive-line", {**wanted, "controller": {"kind": kind}})
        rows[f"{kind}, searched"] = hfc.design(scenario).evaluation
    rows["pid of 2004"] = hfc.evaluate(hfc.load_design("jee-koren-2004-pid"), scenario)

    by_hand = hfc.with_gains(scenario, "cascade", {"position": 20, "integral": 50, "velocity": 0.1})
    rows["cascade by hand"] = hfc.evaluate(by_hand, scenario)
    for name, found in rows.items():
        print(f"{name}: contour error {found.metrics['rms_contour_error_BLU']:.3g} BLU rms")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
