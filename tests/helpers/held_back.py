"""Designs whose limits hold them back, and signals that make them do so."""

import numpy as np
import pytest
from structured_text import FunctionBlock

import hfc_design.api as hfc
from hfc_design.files.design import builtin_designs
from hfc_design.formats.st import text_of
from hfc_design.runtime import Controller

#: Largest commands that hold the built-in designs back.
LIMITS = {"c-axis": 12.0, "feed-drive": 9.0, "milling-table": 6.0, "positioning-stage": 6.0}


def limited(name, limit=None, **changes):
    design = hfc.load_design(name)
    changes |= {"limits.command": limit or LIMITS[design.plant.name]}
    return hfc.load_design(name, changes)


def slow(name, samples_to_the_limit=20, **changes):
    """A design that goes from rest to its largest command in so many samples."""
    design = hfc.load_design(name)
    limit = LIMITS[design.plant.name]
    rate = limit / (samples_to_the_limit * design.controller.sample_time_s)
    return hfc.load_design(name, changes | {"limits": {"command": limit, "command_rate": rate}})


def free(design):
    """The same, with commands as fast as they like."""
    return design.model_copy(update={"limits": design.limits.without_rate()})


def by_hand(asked, change):
    """What a rate lets pass of commands, at most so much more or less than that before."""
    found, before = [], 0.0
    for command in asked:
        before = min(max(command, before - change), before + change)
        found.append(before)
    return np.array(found)


def samples(design, count=400):
    """Signals by name, each (count,): swings that wind an integral up and let it go."""
    rng = np.random.default_rng(3)
    swing = np.sin(np.linspace(0.0, 12.0, count))
    large = {"c-axis": 0.05, "feed-drive": 30.0}.get(design.plant.name, 0.5)
    names = design.kind.reads(design.controller)
    found = {name: large * 0.3 * rng.normal(size=count) for name in names}
    return found | {"error": large * swing}


def stepped(design, signals):
    controller = Controller(design)
    rows = zip(*(column.tolist() for column in signals.values()), strict=True)
    return np.array([controller.step(dict(zip(signals, row, strict=True))) for row in rows])


def in_text(design, signals):
    """What the block of Structured Text commands."""
    block = FunctionBlock(text_of(design))
    rows = zip(*(column.tolist() for column in signals.values()), strict=True)
    return np.array([block.step(**dict(zip(signals, row, strict=True))) for row in rows])


def commanded_alone(design, axis):
    """Whether the design alone commands what the simulator has in its axis, sample by sample."""
    controller = Controller(design)
    told = {key: values.tolist() for key, values in axis.sensed().items()}
    accepted = axis.drive.coefficients(axis.parameters)
    for k, command in enumerate(axis.motion.command.tolist()):
        own = controller.step({key: values[k] for key, values in told.items()})
        assert float(axis.drive.accepted(accepted, own)) == pytest.approx(command, abs=1e-10)


LINEAR = {"ki": 9e3, "signals": {"current": -2.0}, "feed_forward": {"velocity": 40.0}}
SCHEDULED = {"kp": -30.0, "ki": -700.0, "signals": {"deflection": 9.0}}
FORMS = {
    **{name: (name, {}) for name in builtin_designs() if hfc.load_design(name).kind.law},
    "flc that integrates": ("jee-koren-2004-flc", {"controller.integral_gain": 40.0}),
    "flc of form PI": ("jee-koren-2004-flc", {"controller.form": "PI"}),
    "aflc that integrates": ("jee-koren-2004-aflc", {"controller.integral_gain": 40.0}),
    "soflc that integrates": ("jee-koren-1995-soflc", {"controller.integral_gain": 40.0}),
    "hierarchy on a linear part": ("lin-lee-1999-table-1", {"controller.linear": LINEAR}),
    "adapting hierarchy on a linear part": (
        "lin-lee-1999-table-1",
        {"controller.linear": LINEAR, "controller.adaptation": {"largest_move": 1.0}},
    ),
    "hierarchy that schedules": (
        "lin-lee-1999-table-1",
        {"controller.linear": LINEAR, "controller.scheduled": SCHEDULED},
    ),
    "root that adapts": ("lin-lee-1999-table-1", {"controller.adaptation": {"largest_move": 1.0}}),
}
