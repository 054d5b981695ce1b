"""Scenarios from their names, TOML files or mappings; and their output as TOML."""

import re
import tomllib
from collections.abc import Callable, Mapping
from os.path import exists, isdir
from pathlib import Path
from typing import Any, TypeVar

import tomli_w

from hfc_design.core.arguments import a_kind
from hfc_design.core.checkpoint import CONFIG
from hfc_design.core.embedded_files import AnyFile
from hfc_design.core.overrides import Changes, overridden
from hfc_design.core.plugins import resuming
from hfc_design.core.records import NAME, UserError, checked
from hfc_design.core.texts import no_such, read_toml
from hfc_design.core.wording import PATTERNS
from hfc_design.files.design import Design, named_design
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.files.motions import Motion
from hfc_design.files.scenario import Scenario
from hfc_design.reference.commented import explained, rest
from hfc_design.reference.entries import PLANT, Entry, keys_in, scenario_keys, units_of
from plants import machine_of

#: Folder of the scenarios that come with the package, and of the files that they name.
BUILTIN = Path(__file__).parent / "scenarios"
#: A scenario, or what stands for one: a built-in name, a TOML file, the content of such a file.
AnyScenario = Scenario | str | Path | Mapping[str, Any]
Renamed = TypeVar("Renamed", Scenario, Motion)


def builtin_names() -> list[str]:
    """Return the names of the scenarios that come with the package."""
    return sorted(path.stem for path in BUILTIN.glob("*.toml"))


def load_scenario(source: AnyScenario, changes: Changes | None = None) -> Scenario:
    """Load a built-in scenario, a TOML file or a mapping, with ``changes`` of dotted keys.

    A scenario without changes is returned as it is.

    Raises:
        UserError: there is no such scenario, or its text, a value or a change is not allowed.
    """
    changes = changes or {}
    if isinstance(source, Scenario):
        if not changes:
            return source
        source = source.model_dump(mode="json", exclude_none=True)
    if isinstance(source, Mapping):
        data = overridden({"name": "scenario"} | dict(source), changes)
        return scenario_of(data, "scenario", Path())
    if not isinstance(source, str | Path):
        raise UserError(f"argument must be a scenario or the name of one (got {a_kind(source)})")
    name = str(source)
    built_in = name in builtin_names()
    path = BUILTIN / f"{name}.toml" if built_in else Path(name)
    if isdir(path):
        raise UserError(f"{name}: {_folder_told(path)}")
    if not exists(path):  # a path that exists may also be a pipe
        raise no_such("scenario", name, builtin_names())
    data = read_toml(path)
    reference = data.get("reference", {})
    if built_in and "file" in reference:  # files in ``changes`` are relative to the user's folder
        reference["file"] = str(BUILTIN / reference["file"])
    data = overridden({"name": Path(name).stem} | data, changes)
    if data["name"] == Path(name).stem and not re.fullmatch(NAME, data["name"]):
        raise UserError(
            f"{name}: a scenario without a name takes that of its file, which must be "
            f"{PATTERNS[NAME]}; add one, as in name = 'mine'"
        )
    return scenario_of(data, name, Path(name).parent)


def _folder_told(path: Path) -> str:
    """Return advice on a folder that was given in place of a scenario."""
    if exists(path / CONFIG):
        return f"is a run folder; {resuming(path)}, or start again from its {CONFIG}"
    return "is a folder; give a TOML file or the name of a built-in scenario"


def scenario_of(data: Any, source: str | Path, folder: Path) -> Scenario:
    """Return the scenario in ``data``; paths in it are relative to ``folder``.

    Raises:
        UserError: a key or a value is not allowed; the message begins with ``source``.
    """

    def load(name: str) -> Design:
        path = folder / name
        return named_design(str(path) if exists(path) else name)

    return checked(Scenario, data, source, folder, keys_in(data, own_plant), named_design=load)


def own_plant(name: str) -> list[Entry]:
    """Return signals and parameters of a user's own plant, with units; [] for a built-in plant."""
    if name not in ALL_PLANTS.known or name in ALL_PLANTS.built_in:
        return []
    entries, machine = [], machine_of(ALL_PLANTS.get(name))
    for axis, drive in zip(machine.axes, machine.drives, strict=True):
        table = "parameters" if len(machine.axes) == 1 else f"axes.{axis}"
        parameter_units = {
            f"plant.{table}.{key}": unit for key, unit in drive.parameter_units.items()
        }
        entries += [Entry(PLANT, name, "signal", key, unit=x) for key, x in drive.units.items()]
        entries += [
            Entry(PLANT, name, "parameter", key, unit=x) for key, x in parameter_units.items()
        ]
    return entries


def renamed(scenario: Scenario, name: Callable[[str, AnyFile], AnyFile]) -> Scenario:
    """Return the scenario with each file that it names replaced by ``name(key, file)``.

    A key is "reference" or "load". In a table ``axes`` the axis follows ("load-x"). In a motion its
    name comes first ("ramp.reference").
    """
    motions = tuple(_renamed(one, f"{one.name}.", name) for one in scenario.motions)
    return _renamed(scenario, "", name, motions=motions)


def _renamed(
    record: Renamed, head: str, name: Callable[[str, AnyFile], AnyFile], **changes: object
) -> Renamed:
    """Return a scenario or motion with its files replaced; ``head`` is the start of their keys."""
    for key in ("reference", "load"):
        if (part := getattr(record, key)) is not None:
            changes[key] = with_files(part, head + key, name)
    return record.model_copy(update=changes)


def with_files(part: Any, key: str, name: Callable[[str, AnyFile], AnyFile]) -> Any:
    """Return a reference or a load with each file replaced by ``name(key, file)``."""
    changes: dict[str, object] = {}
    if (file := getattr(part, "file", None)) is not None:
        changes["file"] = name(key, file)
    if axes := getattr(part, "axes", None):
        changes["axes"] = {
            axis: with_files(one, f"{key}-{axis}", name) for axis, one in axes.items()
        }
    return part.model_copy(update=changes)


def scenario_toml(scenario: Scenario) -> str:
    """Return the scenario in full as TOML, with every default."""
    return tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True))


def config_toml(scenario: Scenario) -> str:
    """Return ``scenario_toml`` with comments: meanings of keys, at the end keys without values."""
    text = scenario_toml(scenario)
    data = tomllib.loads(text)
    known, units = scenario_keys(data), units_of(scenario.plant.name)
    return explained(text, known, units) + rest(data, known, units)
