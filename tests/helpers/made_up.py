"""Random designs of every kind that has rules."""

import json
from itertools import pairwise

import numpy as np

from hfc_design.controllers.flc.rules import LABELS
from hfc_design.controllers.neural.record import drawn
from hfc_design.files.design import Design

TERMS = 7
SIGNALS = ("error", "deflection", "deflection_rate", "spindle_velocity")
LOW_VELOCITY = {
    "forward": [0.01, -0.9, 5.0],
    "backward": [-0.01, -0.7, -4.0],
    "highest_velocity_mm_s": 8.0,
    "breakaway": [6.0, -5.0],
    "smallest_error": 1.5,
}
INPUTS = (*SIGNALS, "previous_spindle_velocity", "previous_error")


def hierarchy(seed, inputs=5, spread=1.5, **changes):
    """Random terms, tables up to ``spread``, and a random tree over ``inputs`` inputs."""
    random = np.random.default_rng(seed)
    names = list(INPUTS[-inputs:] if inputs < 5 else INPUTS[:inputs])
    free, units = names.copy(), []
    for k in range(inputs - 1):
        column, row = (free.pop(random.integers(len(free))) for _ in range(2))
        table = random.uniform(-spread, spread, (TERMS, TERMS)).tolist()
        units.append({"id": k, "column_input": column, "row_input": row, "consequents": table})
        free.append(f"unit-{k}")
    terms = [
        {
            "label": label,
            "centre": centre,
            "half_width": abs(random.uniform(-0.1, 0.1)),
            "rate": random.uniform(3.0, 40.0),
        }
        for label, centre in zip(LABELS, np.sort(random.uniform(-1.2, 1.2, TERMS)), strict=True)
    ]
    return _design(
        "c-axis",
        kind="pd+hierarchical-fuzzy",
        sample_time_s=0.001,
        pd={"kp": random.uniform(100.0, 900.0), "kd": random.uniform(10.0, 100.0)},
        inputs=[{"name": name, "scale": random.uniform(0.5, 2.0)} for name in names],
        output_scale=10.0,
        terms=terms,
        units=units,
        **changes,
    )


def linear_part(seed):
    """Of a hierarchy: an integral that is often held, gains on signals, what is fed forward."""
    random = np.random.default_rng([seed, 1])
    told = [*SIGNALS[1:], "current"]
    ahead = {name: random.normal(0.0, 20.0) for name in ("velocity", "acceleration", "coulomb")}
    ahead |= {"coulomb_width": random.uniform(0.01, 1.0), "load": random.normal()}
    return {
        "ki": random.choice([0.0, random.uniform(0.0, 50_000.0)]),
        "signals": {name: random.normal(0.0, 100.0) for name in told if random.random() < 0.5},
        "feed_forward": ahead | {"expected_load": random.choice([0.0, 5.0])},
    }


def hierarchy_on_linear(seed, inputs=5, **changes):
    """On a linear part; of five or six inputs one is what the axis follows."""
    found = hierarchy(seed, inputs, linear=linear_part(seed), **changes).model_dump(mode="json")
    own = found["controller"]
    if inputs > 4:
        for key in ("inputs", "units"):
            text = json.dumps(own[key]).replace('"deflection_rate"', '"reference_rate"')
            own[key] = json.loads(text)
    return Design.model_validate(found)


def resonating(design, seed, *frequencies):
    """The same whose linear laws have resonators, with gains of either sign."""
    random = np.random.default_rng([seed, 3])
    data = design.model_dump(mode="json")
    own = data["controller"]
    laws = {"linear": 20_000.0, "scheduled": 2_000.0} if "linear" in own else {}
    for law, size in [(own[key], x) for key, x in laws.items() if key in own] or [(own, 20_000.0)]:
        pairs = random.normal(0.0, size, (len(frequencies), 2)).tolist()
        law["resonators"] = [
            {"frequency_rad_s": x, "in_phase": along, "quadrature": ahead}
            for x, (along, ahead) in zip(frequencies, pairs, strict=True)
        ]
    return Design.model_validate(data)


def network(seed, hidden=25, **changes):
    """A network of a feed drive that learns fast on line."""
    numbers = {"error_unit": 5.0, "change_unit": 2.0, "command_unit": 3.0}
    numbers |= {"rate": 1e-2, "momentum": 0.3, "slope": 0.2}
    weights = drawn(hidden, seed).model_dump()
    return _design(
        "feed-drive", kind="neural", sample_time_s=0.01, weights=weights, **numbers | changes
    )


def scheduled_part(seed):
    """What the root of a hierarchy scales by up to 15: a tenth as large, with its own kp and kd."""
    random = np.random.default_rng([seed, 2])
    gains = {"kp": random.normal(0.0, 20.0), "kd": random.normal(0.0, 2.0)}
    found = linear_part(seed + 1000) | gains | {"ki": random.normal(0.0, 500.0)}
    found["signals"] = {name: 0.1 * gain for name, gain in found["signals"].items()}
    for name in ("velocity", "acceleration", "coulomb", "load"):
        found["feed_forward"][name] *= 0.1
    return found


def scheduling(seed, inputs=5, **changes):
    """A hierarchy on a linear part, whose root scales a linear law."""
    changes["scheduled"] = scheduled_part(seed)
    return hierarchy_on_linear(seed, inputs, **changes)


def fuzzy(kind, seed, rows=TERMS, columns=TERMS, **changes):
    """Random triangles, some overlapping by less than a step of the adaptation."""
    random = np.random.default_rng(seed)
    controller = {
        "kind": kind,
        "sample_time_s": 0.01,
        "error_terms": _triangles(random, 7.0, rows),
        "error_change_terms": _triangles(random, 1.5, columns),
        "rules": {"centroids": random.uniform(-32.0, 32.0, (rows, columns)).tolist()},
        "integral_gain": random.uniform(0.0, 0.2),
        "low_velocity": LOW_VELOCITY,
    }
    if kind in ("aflc", "soflc"):
        controller["adaptation"] = {"k_a": 0.5, "k_b": 0.125, "k_c": 1.0}
    if kind == "aflc":
        controller["adaptation"]["stable_range"] = {"k1_max": 4.5, "k2_max": 5.9}
    return _design("feed-drive", **(controller | changes))


def level(kind, height, **overlaps):
    """The same with one output for all rules, and with ``overlaps`` that may be so small."""
    changes = {"rules": {"centroids": np.full((TERMS, TERMS), height).tolist()}}
    if overlaps:
        own = fuzzy(kind, 1).controller.adaptation.model_dump()
        changes["adaptation"] = own | {"smallest_overlap": overlaps}
    return fuzzy(kind, 1, **changes)


def named(seed, rows, columns):
    """A fuzzy controller of another program, whose rules share the singletons slow and fast."""
    labels = [[("slow", "fast")[(seed + i * j) % 2] for j in range(columns)] for i in range(rows)]
    rules = {"labels": labels, "output_terms": {"slow": -3.5, "fast": 20.25}}
    names = {"error": "gap", "error_change": "drift", "output": "motor"}
    design = fuzzy("flc", seed, rows, columns, rules=rules, names=names)
    data = design.model_dump(mode="json")
    for key in ("error_terms", "error_change_terms"):  # as wide as they can be
        terms = data["controller"][key]
        for lower, upper in pairwise(terms):
            lower["right"], upper["left"] = upper["centre"], lower["centre"]
    return Design.model_validate(data)


def with_options(kind, seed):
    """A fuzzy controller with a dead zone; one that adapts below a curve, narrowing ZR too."""
    changes = {"dead_zone": 1.0}
    if kind != "flc":
        curve = [[0.5, 5.0], [1.5, 4.0], [4.5, 1.0]]
        limits = {"k1_max": 4.5, "k2_max": 4.8, "curve": curve}
        least = {"error": 3.0, "error_change": 0.5}
        changes["adaptation"] = {"k_a": 0.5, "k_b": 0.125, "k_c": 1.0, "narrows_zero": True}
        changes["adaptation"] |= {"stable_range": limits, "smallest_overlap": least}
    return fuzzy(kind, seed, **changes)


def linear(kind, seed, plant="c-axis", **changes):
    """Random gains; a filter, signals, an expected load and parts of the feed-forward now and then.

    The integral is fast, so that it is often held.
    """
    random = np.random.default_rng(seed)
    told = ["deflection", "deflection_rate", "current"] if plant == "c-axis" else ["velocity"]
    names = [name for name in told if random.random() < 0.7]
    ahead = {
        "velocity": random.normal(0.0, 20.0),
        "acceleration": random.choice([0.0, random.normal(0.0, 5.0)]),
        "coulomb": random.normal(0.0, 30.0),
        "coulomb_width": random.uniform(0.01, 1.0),
        "load": random.normal(),
        "expected_load": random.choice([0.0, 5.0]),
    }
    return _design(
        plant,
        kind=kind,
        sample_time_s=0.001,
        kp=random.uniform(-50.0, 3000.0),
        ki=random.choice([0.0, random.uniform(0.0, 50_000.0)]),
        kd=random.uniform(-5.0, 200.0),
        derivative_hz=random.choice([None, 0.0, random.uniform(1.0, 400.0)]),
        signals={name: random.normal(0.0, 100.0) for name in names},
        feed_forward=ahead,
        **changes,
    )


def limited(design, limit):
    """The same that commands no more."""
    return design.model_copy(update={"limits": type(design.limits)(command=limit)})


def _triangles(random, width, count):
    centres = width * (np.arange(count) - (count - 1) / 2 + random.uniform(-0.2, 0.2, count))
    labels = LABELS if count == TERMS else [f"term_{k}" for k in range(count)]
    terms = [{"label": c, "centre": m} for c, m in zip(labels, centres.tolist(), strict=True)]
    for k in range(count - 1):
        left, right = np.sort(random.uniform(centres[k], centres[k + 1], 2)).tolist()
        terms[k]["right"], terms[k + 1]["left"] = right, left
    return terms


def _design(plant, **controller):
    design = {"name": "made-up", "plant": {"name": plant, "parameters": {}}}
    return Design.model_validate({**design, "controller": controller})
