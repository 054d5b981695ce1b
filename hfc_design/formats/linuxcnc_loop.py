"""The simulated machine as components of HAL, and the reference that the loop follows."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.rules import identifier
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.pairing import machine, own_scenario
from hfc_design.formats.writing import rendered
from plants import Drive

#: The queue of reference samples is filled before the first one, so it has to hold them all.
MOST_ROWS = 2000
#: Characters of an axis' name: AXIS-machine.positive-curvature has to fit into 47.
LONGEST_AXIS = 20

Coefficients = list[tuple[str, float]]


class Loop(NamedTuple):
    """What closes the loop on a simulated machine."""

    scenario: str
    axes: dict[str, Coefficients]  # prefix of the axis' names -> what its machine is set to
    substeps: int
    limit: float | None  # of the command
    rows: int
    reference: str  # the file: reference, its rate and the load of each axis, a row a sample


def simulated_loop(design: Design) -> Loop:
    """The scenario of ``design`` for HAL, its first ``MOST_ROWS`` samples.

    Raises:
        UserError: the scenario cannot run from here.
    """
    every = design.controller.sample_time_s
    scenario = own_scenario(design, design.name, [f"simulation.sample_time_s={every!r}"])
    plants = machine(design, scenario)
    samples = scenario.samples()
    columns = []
    for axis in samples.axes:
        columns += [axis.reference, axis.reference_rate, _mean(axis.loads)]
    table = np.stack(columns, axis=1)[:MOST_ROWS]
    names = [_prefix(name) for name in plants.axes] or [""]
    axes = zip(names, plants.machine.drives, plants.values(), strict=True)
    limits = [limit for limit in (scenario.limits.command, design.limits.command) if limit]
    return Loop(
        scenario.name,
        {name: coefficients(drive, parameters) for name, drive, parameters in axes},
        scenario.simulation.substeps,
        min(limits, default=None),
        len(table),
        "".join(" ".join(map(repr, row)) + "\n" for row in table.tolist()),
    )


def plant_component(design: Design) -> str:
    """The component of the nominal machine; it is the same for every design for that plant."""
    name = design.plant.name
    drive = PlantSettings(name=name).machine.drives[0]
    nominal = coefficients(drive, drive.parameters())
    template = f"linuxcnc/hfc_{name.replace('-', '_')}.comp.j2"
    return rendered(template, design, coefficients=nominal)


def coefficients(drive: Drive, parameters: Any) -> Coefficients:
    """The coefficients of a drive by name; those of a part have the part's name before theirs."""
    return list(_flat("", drive.coefficients(parameters)))


def _prefix(axis: str) -> str:
    """What the names of an axis begin with."""
    if len(axis) > LONGEST_AXIS:
        raise UserError(f"plant.axes.{axis}: the names of HAL leave {LONGEST_AXIS} characters")
    return f"{identifier(axis)}-"


def _flat(prefix: str, record: Any) -> Iterator[tuple[str, float]]:
    for name, value in record._asdict().items():
        if hasattr(value, "_asdict"):
            yield from _flat(f"{prefix}{name}_", value)
        else:
            yield prefix + name, float(value)


def _mean(loads: np.ndarray) -> np.ndarray:
    """(steps,) load of each sample, which HAL holds: Simpson's mean of (2 substeps + 1, steps)."""
    weights = np.full(len(loads), 2.0)
    weights[1::2] = 4.0
    weights[[0, -1]] = 1.0
    return np.asarray(weights @ loads / weights.sum())
