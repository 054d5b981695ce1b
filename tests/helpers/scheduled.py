"""Hierarchies on linear laws, by hand and in scenarios."""

import numpy as np
from wiring import units as wired

from hfc_design import api
from hfc_design.files.design import Design

INPUTS = [
    {"name": "error", "scale": 3000.0},
    {"name": "error_rate", "scale": 50.0},
    {"name": "reference_rate", "scale": 50.0},
]
SMALL = {"simulation.duration_s": 0.2, "search.population": 12, "search.generations": 6}
NAMES = ("reference_rate", "error", "spindle_velocity")
SCALE = 50.0


def on_linear(name="c-axis-ramp", part=None, **changes):
    own = {"kind": "pd+hierarchical-fuzzy", "inputs": INPUTS, "linear": part or {}}
    return api.load_scenario(name, {"controller": own, **SMALL, **changes})


def of_two_laws(names=NAMES, **changes):
    own = {
        "inputs": [{"name": name, "scale": SCALE} for name in names],
        "output_scale": 2.0,
        "linear": {"expected_load": 5.0, "load_frequencies_rad_s": [1.0, 50.0]},
        "schedules": True,
        **changes,
    }
    return api.load_scenario("c-axis-ramp", {"controller": own, "search.preset": "cma", **SMALL})


def root(design, told, before):
    """The root's output by LL eq. 3 and 4 with exp and loops; ``before`` is the last sample."""
    values = {}
    for item in design.controller.inputs:
        name = item.name
        reading = before.get(name[9:], 0.0) if name.startswith("previous_") else told[name]
        values[name] = min(max(item.scale * reading, -1.0), 1.0)
    for unit in wired(design):
        values[unit.name] = unit.expected(values[unit.row], values[unit.column])
    return values[unit.name]


def changed(design, **parts):
    data = design.model_dump(mode="json")
    data["controller"] |= parts
    return Design.model_validate(data)


def says(value, design):
    """The tables of a design's units that say one value everywhere."""
    table = np.full((7, 7), value).tolist()
    return [
        u | {"consequents": table} for u in design.model_dump(mode="json")["controller"]["units"]
    ]
