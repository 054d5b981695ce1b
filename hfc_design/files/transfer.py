"""Use of a design on another scenario: which values of its own it keeps there."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

from hfc_design.core.embedded_files import AnyFile, content_of
from hfc_design.core.numbers import Json
from hfc_design.core.overrides import flat
from hfc_design.core.records import UserError
from hfc_design.core.texts import LARGEST_TABLE
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import machine, with_converter
from hfc_design.files.machine import PlantSettings, SensorSettings
from hfc_design.files.named_scenario import load_scenario, with_files
from hfc_design.files.scenario import Scenario
from hfc_design.motion.references import Load

HEAD = "Kept from the scenario that the design was made with, or this scenario's:"
#: An imported file of rules names neither machine nor limits; the import assumes those of a plant.
IMPORTED = "The file names no machine; kept from the import's assumptions, or this scenario's:"
KEPT, UNKNOWN = "kept", "this scenario's; the design does not record what it was made with"


def transfer_report(design: Design, scenario: Scenario) -> list[str]:
    """Return lines on machine, limits, sensors, load: which are the design's or the scenario's.

    Raises:
        UserError: the two are for different plants or sample times.
    """
    descriptions = {
        "machine": _machine(design, scenario),
        "limits": _limits(design, scenario),
        "sensors": _text(design, scenario, "sensors"),
        "load": _text(design, scenario, "load"),
    }
    imported = str(design.provenance.get("source", "")).startswith("imported from")
    head = IMPORTED if imported else HEAD
    return [head, *(f"  {name:8} {text}" for name, text in descriptions.items())]


def _machine(design: Design, scenario: Scenario) -> str:
    """Return a text: parameters that the scenario changes, else those that the design keeps."""
    if design.plant.name != scenario.plant.name:
        return f"this scenario's: {scenario.plant.name} (made for {design.plant.name})"
    free: Json = {"parameters": {}, "axes": {axis: {} for axis in scenario.plant.axes}}
    plain = scenario.model_copy(update={"plant": scenario.plant.model_copy(update=free)})
    design_values, here, alone = map(
        _parameters, (machine(design, plain), machine(design, scenario), scenario.plant)
    )
    if design_values != here and not states_machine(design):
        return UNKNOWN
    if changes := _changes(design_values, here):
        return f"{KEPT}, except {', '.join(changes)}"
    differ = (key for key, x in here.items() if x != alone[key])
    retained = [f"{key} {_word(here[key])} (not {_word(alone[key])})" for key in differ]
    return f"{KEPT}: {', '.join(retained)}" if retained else KEPT


def states_machine(design: Design) -> bool:
    """Return True if a design records the machine that it was made for, not only its plant."""
    plant = design.plant
    return bool(plant.parameters or any(plant.axes.values()) or design.provenance.get("scenario"))


def _parameters(plant: PlantSettings) -> dict[str, Any]:
    """Return the parameters of all axes; names begin with the axis if there are several."""
    each = plant.each()
    return {
        (f"{axis.name}." if len(each) > 1 else "") + key: number
        for axis in each
        for key, number in axis.parameters._asdict().items()
    }


def _limits(design: Design, scenario: Scenario) -> str:
    """Return a text on limits: the controller keeps its own, the drive has the scenario's."""
    here = with_converter(scenario, design).limits
    axes = scenario.plant.machine.axes
    parts, controller_limits = [], []
    for axis in axes:
        head = f"{axis}." if len(axes) > 1 else ""
        axis_limits = design.limits.of(axis)
        keys = [key for key in type(axis_limits).model_fields if key != "axes"]
        pair = ({head + key: getattr(x, key) for key in keys} for x in (axis_limits, here.of(axis)))
        parts += _changes(*pair)
        for key in ("command", "command_rate"):
            if (limit := getattr(axis_limits, key)) is not None:
                controller_limits.append(f"{head}{key} {limit:g}")
    if not parts:
        return KEPT
    inside = (
        f"applied by the controller ({', '.join(controller_limits)}); " if controller_limits else ""
    )
    return f"{inside}the drive here has {', '.join(parts)}"


def _text(design: Design, scenario: Scenario, key: str) -> str:
    """Return a text on sensors or load (the ``key``), which are always the scenario's."""
    made: Any = design.provenance.get("scenario")
    with suppress(UserError, ValueError):  # ``made`` is of an earlier version, or edited
        if isinstance(made, str):
            made = load_scenario(made).model_dump(mode="json")
        if not isinstance(made, dict):
            return UNKNOWN
        here = getattr(scenario, key)
        if key == "load" and (scenario.motions or made.get("motions")):
            each = ({**made, **one} for one in made.get("motions") or [{}])
            loads = [_plain(type(here).model_validate(one.get(key) or {})) for one in each]
            same = loads == [_plain(one.load) for one in scenario.each_motion()]
            return KEPT if same else "this scenario's, in each motion"
        original = type(here).model_validate(made.get(key) or {})
        changes = _changes(_plain(original), _plain(here))
        return f"this scenario's: {', '.join(changes)}" if changes else KEPT
    return UNKNOWN


def _plain(part: Load | SensorSettings) -> Json:
    """Return a part of a scenario by dotted keys, with a hash of its content for each file."""
    if isinstance(part, Load):
        part = with_files(part, "load", _by_content)
    return dotted(part.model_dump(mode="json"))


def _by_content(key: str, file: AnyFile) -> Path:
    return Path(f"sha256-{sha256(content_of(file, LARGEST_TABLE)).hexdigest()[:12]}")


def _changes(made: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """Return a text for each value that differs: its value here, and in the design's origin."""
    keys: Iterable[str] = {**made, **here}
    differ = (key for key in keys if made.get(key) != here.get(key))
    return [f"{key} {_word(here.get(key))} (made with {_word(made.get(key))})" for key in differ]


def _word(value: Any) -> str:
    if value is None or value == []:
        return "none"
    if isinstance(value, list):
        return f"{len(value)} of them"
    return f"{value:g}" if isinstance(value, float) else str(value)


def dotted(table: Json) -> Json:
    """Return a table of tables as one table with dotted keys, without empty tables."""
    return {key: x for key, x in flat(table).items() if x != {}}
