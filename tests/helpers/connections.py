"""Simulated motions as a machine's sensors would have told them, for connected designs."""

import numpy as np

import hfc_design.api as hfc
from hfc_design.files.loop_setup import own_scenario
from hfc_design.formats.connection import connect

#: Designs that have a loop of one axis, and what their scenario changes.
OBSERVED = ["velocity='observer'", "observer_hz=80.0", "encoder_resolution=1e-5", "noise=3e-6"]
DIFFERENCES = ["velocity='encoder'", "difference_samples=3", "encoder_resolution=1e-5"]
CONVERTER = ["limits.command=90.0", "limits.resolution=0.06", "limits.command_rate=40000.0"]
CONVERTER_OF_MACHINES = ["limits.resolution=0.01", "limits.command_rate=400.0"]
CASES = {
    "lin-lee-1999-table-1": [f"sensors.{x}" for x in OBSERVED],
    "lin-lee-1999-table-2": [*(f"sensors.{x}" for x in DIFFERENCES), *CONVERTER],
    "pd-only": ["sensors.velocity='encoder'", "sensors.encoder_resolution=1.7e-6"],
    "pd-only on a turn": [
        "sensors.turn=0.004",
        "sensors.velocity='observer'",
        "sensors.observer_hz=90.0",
    ],
    "pd-only on a turn in differences": ["sensors.turn=0.004", "sensors.velocity='encoder'"],
    "jee-koren-2004-aflc": [],
    "jee-koren-2004-pid": ["limits.command=60.0", "limits.resolution=0.5"],
    "huang-soc": ["sensors.velocity='observer'", "sensors.observer_hz=60.0"],
    "huang-neural": [],
    "emps-cascade": [],
}
#: Of a whole machine.
MACHINES = {
    "huang-cross-coupled": [*CONVERTER_OF_MACHINES, "sensors.velocity='encoder'"],
    "lin-gai-2009-fuzzy-sliding-compensated": [
        "sensors.velocity='observer'",
        "sensors.observer_hz=30.0",
        "sensors.axes.c.velocity='encoder'",
    ],
}


def made(name):
    """A design on its scenario with the changes of its case, and that."""
    design, changes = hfc.load_design(name.split(" ")[0]), (CASES | MACHINES)[name]
    scenario = own_scenario(design, name, changes)
    kept = {key: getattr(scenario.limits, key) for key in ("command", "command_rate")}
    limits = design.limits.model_copy(update={k: x for k, x in kept.items() if x is not None})
    told = {"scenario": scenario.model_dump(mode="json", exclude_unset=True)}
    return design.model_copy(update={"limits": limits, "provenance": told}), scenario


def connected(name):
    """The connected design of a case."""
    return connect(made(name)[0])


def simulated(name):
    """That, what its sensors tell as rows of its inputs, and how its axes move, or the first."""
    design, scenario = made(name)
    axes = hfc.evaluate(design, scenario).axes[: None if design.kind.law is None else 1]
    found = connect(design)
    columns = [column for axis in axes for column in _told(found, axis)]
    path = scenario.samples().path
    if design.kind.law is None and len(axes) == 2:
        columns += [*path.tangent, path.curvature]
    return found, np.array(columns, float).T, axes


def _told(found, axis):
    """What an axis tells, a column each."""
    readings = {key: list(map(float, x)) for key, x in axis.motion.state._asdict().items()}
    for k, angle in enumerate(axis.drive.encoders):
        if len(axis.happens.noise) > k:
            off = map(float, axis.happens.noise[k])
            readings[angle] = [a + b for a, b in zip(readings[angle], off, strict=True)]
    told = readings | {
        "reference": axis.happens.reference,
        "reference_rate": axis.happens.reference_rate,
        "reference_acceleration": axis.happens.reference_acceleration,
        "enable": [1.0] * len(axis.motion.command),
    }
    zero = [0.0] * len(axis.motion.command)
    return [told.get(key, zero) for key in found.connected.units]
