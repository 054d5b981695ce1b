"""How the scenario of a design measures an axis (encoders, velocities) and converts commands."""

from collections.abc import Iterable
from typing import NamedTuple

from hfc_design.core.records import UserError
from hfc_design.files.design import Design, Limits
from hfc_design.files.loop_setup import machine, own_scenario, with_converter
from hfc_design.files.machine import Axis, SensorSettings
from hfc_design.files.scenario import Scenario
from hfc_design.formats.writing import meanings_of
from plants import Drive
from plants.drive import fed_back


class Sensed(NamedTuple):
    """Measurement of one axis, or of several axes that are measured alike."""

    axes: tuple[str, ...]
    position: str  # name of the position from which the error is formed
    meaning: str  # of this position; "" if unknown
    unit: str  # of position and error
    millimetres: float | None  # length of one such unit [mm]; None: it is not a length
    velocity: str  # name of the velocity from which the error rate is formed
    rates: tuple[str, ...]  # signals that the controller reads and that depend on velocities
    sensors: SensorSettings
    counts: bool  # whether the machine's own encoder counts in steps
    step: float  # of this encoder [unit]; 0: no parameter of the plant gives it
    limits: Limits  # of the command, with the converter


class Scene(NamedTuple):
    """Scenario of a design, and how it measures each axis."""

    scenario: str  # its name; "" if it cannot be run here
    reason: str  # why it cannot be run; "" if it can
    named: bool  # whether the design names it; if not, it is the default of the plant
    each: tuple[Sensed, ...]


def scene(design: Design, reads: Iterable[str]) -> Scene:
    """Return how a design's scenario measures the axes; ``reads`` are the controller's signals."""
    named = "scenario" in design.provenance
    try:
        scenario = own_scenario(design, design.name)
        axes = machine(design, scenario).each()
    except UserError as error:
        return Scene("", error.lines[0], named, ())
    scenario = with_converter(scenario, design)
    alike: list[Sensed] = []
    for axis in (axis for axis in axes if design.axis in ("", axis.name)):
        sensed = _sensed(axis, scenario, tuple(reads))
        same = [k for k, one in enumerate(alike) if one._replace(axes=()) == sensed]
        k = same[0] if same else len(alike)
        before = alike[k].axes if same else ()
        alike[k : k + 1] = [sensed._replace(axes=(*before, axis.name))]
    return Scene(scenario.name, "", named, tuple(alike))


def _sensed(axis: Axis, scenario: Scenario, reads: tuple[str, ...]) -> Sensed:
    sensors = scenario.sensors.of(axis.name)
    drive = axis.drive if sensors.feedback is None else fed_back(axis.drive, sensors.feedback)
    position, velocity = drive.seen
    return Sensed(
        (),
        position,
        meanings_of(drive).get(position, ""),
        drive.units["error"],
        axis.length,
        velocity,
        _rates(drive, axis, reads),
        sensors,
        _counts(drive, axis),
        axis._replace(drive=drive).resolution,
        scenario.limits.of(axis.name),
    )


def _rates(drive: Drive, axis: Axis, reads: tuple[str, ...]) -> tuple[str, ...]:
    """Return ``error_rate`` and other signals in ``reads`` that change with encoder velocities."""
    fixed, state = drive.coefficients(axis.parameters), drive.initial_state(0.0)
    speeds = {rate: 1.0 + 0.7 * k for k, rate in enumerate(drive.encoders.values())}
    moving = state._replace(**speeds)
    before, after = drive.signals(fixed, state), drive.signals(fixed, moving)
    changed = [name for name in before if before[name] != after[name]]
    return tuple(name for name in reads if name == "error_rate" or name in changed)


def _counts(drive: Drive, axis: Axis) -> bool:
    """True if the machine's own encoder reads a position in steps."""
    fixed, state = drive.coefficients(axis.parameters), drive.initial_state(0.0)
    odd = 0.123456789012
    seen = drive.measured(fixed, state._replace(**{drive.seen[0]: odd}))
    return bool(abs(float(getattr(seen, drive.seen[0])) - odd) > 1e-12)
