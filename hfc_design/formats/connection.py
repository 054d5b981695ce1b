"""A design as it is connected to a machine: its code reads what the machine's sensors tell."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.codegen.memory import merged
from hfc_design.codegen.recorded import used
from hfc_design.controllers.connected import SWITCHES, TRUTHS, Connection, Sensing, connected
from hfc_design.controllers.controller import FOLLOWED, AxisLaw, units_of
from hfc_design.core.numbers import Memory, Scalar, Truth, Xp
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.machine import Axis
from hfc_design.files.pairing import machine, own_scenario, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.formats import laws, plant_code, writing
from hfc_design.simulation.sensors import largest_command, observer_gains
from plants import Drive
from plants.drive import fed_back


class Connected(NamedTuple):
    """What the code of a connected design reads, and what makes a law read it."""

    units: dict[str, str]  # name -> unit, of all that it reads
    meanings: dict[str, str]
    around: Callable[[AxisLaw], AxisLaw]
    scenario: str
    fed_back: str  # the reading of the position

    @property
    def truths(self) -> list[str]:
        """Those of what it reads that are true or false."""
        return [name for name in self.units if name in TRUTHS]


def connect(design: Design) -> Design:
    """The design with code of raw readings, as the sensors of its scenario have them.

    Itself where it is none of an axis, or where its scenario cannot run from here.

    Raises:
        UserError: its axes are measured in different ways.
    """
    if design.kind.law is None:
        return design
    try:
        made = own_scenario(design, design.name)
        plant = machine(design, made)
        scenario = with_converter(made, design)
    except UserError:
        return design
    own = [axis for axis in plant.each() if design.axis in ("", axis.name)]
    if not own:
        return design  # it is for an axis that its scenario has not
    sensed = [_sensing_of(axis, scenario) for axis in own]
    if any(one != sensed[0] for one in sensed[1:]):
        told = "its axes are measured in different ways, and one code is for all of them"
        raise UserError(f"design {design.name}: {told}; export it bare")
    drive = _fed_back(own[0], scenario)
    units = dict.fromkeys(SWITCHES, "") | units_of(drive.units) | plant_code.state_units(drive)
    fields = drive.initial_state(0.0)._fields
    meanings = dict(FOLLOWED) | SWITCHES
    of_drive = writing.meanings_of(drive)
    meanings |= {name: of_drive.get(name, "as its sensor reads it") for name in fields}
    units |= {"preset": drive.units["command"], "largest_error": drive.units["error"]}
    every = {name: units[name] for name in (*SWITCHES, *FOLLOWED, *fields)}
    found = design.model_copy()
    rated: tuple[str, ...] = ()
    for _ in range(2):  # the first time it shows which velocities are read
        around = _around(design, own[0], scenario, rated)
        found._connected = Connected(every, meanings, around, scenario.name, drive.seen[0])
        read = used(laws.recorded_law(found))
        if scenario.sensors.of(own[0].name).velocity == "tachometer":
            break
        rated = tuple(angle for angle, rate in drive.encoders.items() if rate in read)
    units = {name: unit for name, unit in every.items() if name in read}
    found._connected = found._connected._replace(units=units)
    return found


def _fed_back(axis: Axis, scenario: Scenario) -> Drive:
    """The drive of an axis with the encoder fed back that the scenario names."""
    encoder = scenario.sensors.of(axis.name).feedback
    return axis.drive if encoder is None else fed_back(axis.drive, encoder)


def _sensing_of(axis: Axis, scenario: Scenario) -> tuple[Any, ...]:
    """What of an axis decides how it is measured: also what its drive tells of odd states."""
    drive = axis.drive
    fixed, state = drive.coefficients(axis.parameters), drive.initial_state(0.0)
    told = []
    for place in (0.1234567, -7.654321, 123.4567):
        here = type(state)(*(place * (1.0 + 0.37 * k) for k in range(len(state))))
        seen = drive.measured(fixed, here)
        told += [*map(float, seen), *map(float, drive.signals(fixed, seen).values())]
    return drive, scenario.sensors.of(axis.name), scenario.limits.of(axis.name), told


def _around(
    design: Design, axis: Axis, scenario: Scenario, rated: tuple[str, ...]
) -> Callable[[AxisLaw], AxisLaw]:
    """What connects a law to an axis of which the rates of some angles are formed."""
    wanted, limits = scenario.sensors.of(axis.name), scenario.limits.of(axis.name)
    drive = _fed_back(axis, scenario)
    fixed, record = drive.coefficients(axis.parameters), type(drive.initial_state(0.0))
    every = design.controller.sample_time_s
    position, velocity = drive.seen
    sensing = Sensing(
        position,
        velocity,
        dict(drive.encoders),
        rated,
        wanted.encoder_resolution or None,
        wanted.velocity,
        wanted.difference_samples,
        observer_gains(wanted.observer_hz or 0.0, every),
        wanted.turn,
        {name: one.resolution for name, one in wanted.readings.items() if one.resolution},
        record._fields,
        _plain(lambda read: drive.measured(fixed, record(**read))._asdict()),
        _plain(lambda read: dict(drive.signals(fixed, record(**read)))),
    )
    rested, begun = partial(_rested, laws.begun_law(design)), _begun
    largest = largest_command(limits)
    change, step = design.changes([design.axis])[design.axis], limits.resolution or None

    def around(law: AxisLaw) -> AxisLaw:
        own = Connection(law, sensing, change, step, largest, rested, begun)
        return connected(own, every)

    return around


def _plain(function: Callable[[dict[str, Scalar]], dict[str, Scalar]]) -> Callable[..., Any]:
    """The same of numbers, whatever a drive makes of them: JAX would make them of its own."""

    def told(read: dict[str, Scalar]) -> dict[str, Scalar]:
        values = read.values()
        if any(isinstance(x, jax.core.Tracer) for x in values):
            return function(read)
        with jax.enable_x64(True):
            found = function(read)
        single = all(isinstance(x, float) for x in values)
        return {name: float(x) if single else np.asarray(x) for name, x in found.items()}

    return told


def _rested(start: Memory, xp: Xp, fresh: Truth, memory: Memory) -> Memory:
    """A memory without its past: numbers as they ``start``, but not arrays, which are learnt."""

    def chosen(now: Any, first: Any) -> Memory:
        plain = isinstance(first, float | int) and not isinstance(first, bool)
        return xp.where(fresh, first, now) if plain else now

    return merged(chosen, memory, start)


def _begun(xp: Xp, fresh: Truth, memory: Memory, first: Memory) -> Memory:
    """A memory, or where it is fresh what a first sample begins with."""

    def chosen(now: Any, first: Any) -> Memory:
        if now is None:
            return xp.where(fresh, 0.0, 1.0) > 0.5 if first is False else now
        return xp.where(fresh, first, now)

    return merged(chosen, memory, first)
