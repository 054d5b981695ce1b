"""A machine that says by its numbers whether, when and where it diverges."""

from typing import Any, NamedTuple

import hfc_design.api as hfc


class Parameters(NamedTuple):
    cools: float = 0.0  # decay rate of the heat [1/s]
    burns: float = 0.0  # flame' = burns flame^2 [1/s]


class State(NamedTuple):
    place: Any
    speed: Any
    heat: Any
    flame: Any


def step(p, x, force, loads, dt):
    def rates(x, load):
        heat, flame = p.cools * (1.0 - x.heat), p.burns * x.flame * x.flame
        return State(x.speed, force - x.speed - load, heat, flame)

    new = hfc.rk4(rates, x, loads, dt)
    return new._replace(place=new.place + 0.0 * (new.heat + new.flame))  # nan shows there


OVEN = hfc.Plant(
    name="oven",
    parameters=Parameters,
    fault=lambda changes: None,
    units={"error": "m", "error_rate": "m/s", "command": "N", "load": "N"},
    initial_state=lambda zero: State(zero, zero, zero, zero + 1.0),
    step=step,
    signals=lambda p, x: {},
    position="place",
    velocity="speed",
    encoders={"place": "speed"},
)


def baking(seconds=0.6, **parameters):
    return hfc.load_scenario(
        {
            "name": "bakes",
            "plant": {"name": "oven", "parameters": parameters},
            "reference": {"kind": "ramp", "velocity": 0.1},
            "simulation": {"duration_s": seconds},
            "controller": {"kind": "pd", "ranges": {"kp": [1.0, 1e3], "kd": [1.0, 1e3]}},
        }
    )
