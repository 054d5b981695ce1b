"""Connection of a design to a machine: its code then reads the raw values of the sensors."""

from collections.abc import Callable
from functools import partial
from itertools import chain
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.codegen.memory import by_axis, in_order, merged
from hfc_design.codegen.recorded import used
from hfc_design.controllers.connected import (
    SWITCHES,
    TRUTHS,
    Begins,
    ConnectedMachine,
    Connection,
    Sensing,
    connected,
)
from hfc_design.controllers.controller import FOLLOWED, AxisLaw, Controller, units_of, within_rate
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Memory, Scalar, Truth, Xp
from hfc_design.core.records import UserError, option
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import machine, own_scenario, slower_drives, with_converter
from hfc_design.files.machine import Axis, measured_apart
from hfc_design.files.scenario import Scenario
from hfc_design.formats import laws, plant_code, writing
from hfc_design.motion.contour import local_error
from hfc_design.simulation.sensors import largest_command, observer_gains
from plants import Drive
from plants.drive import fed_back

#: Signal -> unit, and signal -> meaning.
Known = tuple[dict[str, str], dict[str, str]]


class Connected(NamedTuple):
    """Inputs of a connected design's code, and the function that makes a law read them."""

    units: dict[str, str]  # input -> unit, or "" if axes differ; a machine has each input per axis
    meanings: dict[str, str]  # input -> meaning
    around: Callable[[AxisLaw], AxisLaw]  # law of signals -> law of raw sensor values
    machine: Controller | None  # controller of all axes; None for the controller of one axis
    each: dict[str, Known]  # axis -> units and meanings of its signals
    fed_back: dict[str, str]  # axis -> reading of the position that is fed back
    steps: dict[str, dict[str, float]]  # axis -> reading -> step to which it is rounded

    @property
    def truths(self) -> list[str]:
        """Names of the inputs that are true or false."""
        return [name for name in self.units if name in TRUTHS]


def connect(design: Design, scenario: Scenario | None = None) -> Design:
    """Return a copy of the design whose code reads the raw values of a scenario's sensors.

    Without ``scenario`` the scenario of the design itself is used.

    Raises:
        UserError: the scenario cannot be run here or has other axes; or one code is to serve
            several axes whose drives or sensors differ.
    """
    begin, bare = f"design {design.name}: its sensors are not known", option("bare", True)
    try:
        every = f"simulation.sample_time_s={design.controller.sample_time_s!r}"
        made = scenario or own_scenario(design, design.name, [every])
        plant = machine(design, made)
        scenario = with_converter(made, design)
    except UserError as error:
        message = f"{begin}, as its scenario cannot run: {error.args[0]}"
        raise UserError(f"{message}; with {bare} only the code of the law is exported") from None
    axes = [axis for axis in plant.each() if design.axis in ("", axis.name)]
    whole = laws.machine_axes(design)
    if not axes or (whole and tuple(axis.name for axis in axes) != whole):
        message = f"the scenario {scenario.name} has no {design.axis or ' '.join(whole)}"
        raise UserError(f"{begin}, {message}; with {bare} only the code of the law is exported")
    sensed = [_sensing_of(axis, scenario) for axis in axes]
    if not whole and any(one != sensed[0] for one in sensed[1:]):
        message = "its axes have different drives or sensors, but share one code"
        raise UserError(f"design {design.name}: {message}; export it with {bare}")
    drives = {axis.name: _fed_back(axis, scenario) for axis in axes}
    each_told = {name: _text(drive) for name, drive in drives.items()}
    connected = design.model_copy()
    rated: dict[str, tuple[str, ...]] = {axis.name: () for axis in axes}
    read: set[str] = set()
    for _ in range(2):  # the first pass finds which velocities are read
        connected._connected = _connected(design, axes, scenario, rated, each_told)
        known = used(laws.recorded_law(connected))
        heads = [f"{identifier(axis)}_" for axis in drives] if whole else [""]
        each = [{x.removeprefix(head) for x in known if x.startswith(head)} for head in heads]
        read = {*chain.from_iterable(each)}
        for axis, its in zip(axes, each, strict=False):
            if scenario.sensors.of(axis.name).velocity != "tachometer":
                pairs = drives[axis.name].encoders.items()
                rated[axis.name] = tuple(angle for angle, rate in pairs if rate in its)
        if not any(rated.values()):
            break
    units = {name: unit for name, unit in connected._connected.units.items() if name in read}
    connected._connected = connected._connected._replace(units=units)
    return connected


def _text(drive: Drive) -> Known:
    """Return units and meanings of all inputs that code can read of a drive, and of its command."""
    known = dict.fromkeys(SWITCHES, "") | units_of(drive.units) | plant_code.state_units(drive)
    known |= {"preset": drive.units["command"], "largest_error": drive.units["error"]}
    of_drive = dict.fromkeys(_readings(drive), "as its sensor reads it")
    of_drive |= writing.meanings_of(drive)
    return known, of_drive | FOLLOWED | SWITCHES


def _readings(drive: Drive) -> dict[str, None]:
    """Return as keys the readings of a drive: fields of its state, and signals without encoder."""
    return dict.fromkeys((*drive.initial_state(0.0)._fields, *measured_apart(drive)))


def _connected(
    design: Design,
    axes: list[Axis],
    scenario: Scenario,
    rated: dict[str, tuple[str, ...]],
    known_signals: dict[str, Known],
) -> Connected:
    """Return a design's connection; ``rated``: axis -> angles whose velocities the code forms."""
    each = tuple(_connection(design, axis, scenario, rated[axis.name]) for axis in axes)
    whole, every = laws.machine_axes(design), design.controller.sample_time_s
    start = within_rate(laws.begun_law(design))
    begins = Begins(partial(_rested, start, whole), partial(_begun, whole))
    controller = None
    if whole:
        limits = design.limits.commands(whole)
        law, largest = design.kind.controller_of(design.controller, limits), tuple(limits.values())
        controller = ConnectedMachine(law, each, largest, every, begins, local_error)
    pairs = [*zip(axes, each, strict=True)]
    fed = {axis.name: one.sensing.position for axis, one in pairs}
    steps = {axis.name: _steps(axis, one.sensing) for axis, one in pairs}

    def around(law: AxisLaw) -> AxisLaw:
        return connected(law._replace(sample_time=every), each[0], begins)

    names = dict.fromkeys((*SWITCHES, *FOLLOWED, *chain(*(one.sensing.fields for one in each))))
    units: dict[str, str] = {}
    meanings: dict[str, str] = {}
    for known, means in known_signals.values():  # a unit is "" if it differs between axes
        meanings |= means
        of_axis = {name: known[name] for name in names if name in known}
        units |= {name: unit * (units.get(name, unit) == unit) for name, unit in of_axis.items()}
    return Connected(units, meanings, around, controller, known_signals, fed, steps)


def _fed_back(axis: Axis, scenario: Scenario) -> Drive:
    """Return the drive of an axis, with feedback from an encoder if the scenario names one."""
    encoder = scenario.sensors.of(axis.name).feedback
    return axis.drive if encoder is None else fed_back(axis.drive, encoder)


def _steps(axis: Axis, sensing: Sensing) -> dict[str, float]:
    """Return reading -> step of its sensor, for an axis; readings without steps are left out."""
    of_drive = {
        angle: float(getattr(axis.parameters, key)) for angle, key in axis.drive.resolutions.items()
    }
    encoders = {angle: sensing.resolution or of_drive.get(angle) for angle in sensing.encoders}
    return {name: step for name, step in {**encoders, **sensing.apart}.items() if step}


def _sensing_of(axis: Axis, scenario: Scenario) -> tuple[Any, ...]:
    """Return drive, sensors, limits and test readings of an axis; equal means measured alike."""
    drive = axis.drive
    fixed, state = drive.coefficients(axis.parameters), drive.initial_state(0.0)
    readings = []
    for place in (0.1234567, -7.654321, 123.4567):
        here = type(state)(*(place * (1.0 + 0.37 * k) for k in range(len(state))))
        seen = drive.measured(fixed, here)
        readings += [*map(float, seen), *map(float, drive.signals(fixed, seen).values())]
    return drive, scenario.sensors.of(axis.name), scenario.limits.of(axis.name), readings


def _connection(
    design: Design, axis: Axis, scenario: Scenario, rated: tuple[str, ...]
) -> Connection:
    wanted, limits = scenario.sensors.of(axis.name), scenario.limits.of(axis.name)
    drive = _fed_back(axis, scenario)
    fixed, record = drive.coefficients(axis.parameters), type(drive.initial_state(0.0))
    every = design.controller.sample_time_s
    position, velocity = drive.seen
    readings = wanted.readings
    apart = {x: readings[x].resolution if x in readings else 0.0 for x in measured_apart(drive)}

    def of_state(read: dict[str, Scalar]) -> dict[str, Scalar]:
        return {name: read[name] for name in record._fields}

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
        apart,
        tuple(_readings(drive)),
        _plain(lambda read: drive.measured(fixed, record(**of_state(read)))._asdict()),
        _plain(lambda read: dict(drive.signals(fixed, record(**of_state(read))))),
    )
    name = axis.name if laws.machine_axes(design) else design.axis
    change = slower_drives(design, scenario)[axis.name] or design.changes([name])[name]
    step, largest = limits.resolution or None, largest_command(limits)
    bound = design.limits.of(name).command  # limit that the law applies itself
    return Connection(sensing, change, step, None if not step and largest == bound else largest)


def _plain(function: Callable[[dict[str, Scalar]], dict[str, Scalar]]) -> Callable[..., Any]:
    """Wrap a drive's function so that it returns floats or NumPy arrays, not arrays of JAX."""

    def signals_of(read: dict[str, Scalar]) -> dict[str, Scalar]:
        values = read.values()
        if any(isinstance(x, jax.core.Tracer) for x in values):
            return function(read)
        with jax.enable_x64(True):
            signals = function(read)
        single = all(isinstance(x, float) for x in values)
        return {name: float(x) if single else np.asarray(x) for name, x in signals.items()}

    return signals_of


def _rested(start: Memory, axes: tuple[str, ...], xp: Xp, fresh: Truth, memory: Memory) -> Memory:
    """Return the memory; where ``fresh``, numbers are those of ``start``, learned arrays stay."""

    def chosen(now: Any, first: Any) -> Memory:
        plain = isinstance(first, float | int) and not isinstance(first, bool)
        return xp.where(fresh, first, now) if plain else now

    return in_order(merged(chosen, by_axis(memory, axes), start))


def _begun(axes: tuple[str, ...], xp: Xp, fresh: Truth, memory: Memory, first: Memory) -> Memory:
    """Return the memory, but the memory ``first`` of a first sample where ``fresh`` is true."""

    def chosen(now: Any, first: Any) -> Memory:
        if now is None:
            return xp.where(fresh, 0.0, 1.0) > 0.5 if first is False else now
        return xp.where(fresh, first, now)

    if memory is first:
        return memory
    return in_order(merged(chosen, by_axis(memory, axes), by_axis(first, axes)))
