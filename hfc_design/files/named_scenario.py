"""Scenarios by name: built in, in a TOML file, as a mapping; and as TOML again."""

from collections.abc import Callable, Mapping
from os.path import exists
from pathlib import Path
from typing import Any

import tomli_w

from hfc_design.core.dotted import Changes, changed
from hfc_design.core.records import UserError, checked
from hfc_design.core.texts import read_toml
from hfc_design.files.design import Design, named_design
from hfc_design.files.scenario import Scenario

#: The scenarios that come with the package, and the files that they name.
BUILTIN = Path(__file__).parent / "scenarios"
#: A scenario, or what names one: a built-in name, a TOML file, what would stand in one.
AnyScenario = Scenario | str | Path | Mapping[str, Any]


def builtin_names() -> list[str]:
    """Names of the scenarios that come with the package."""
    return sorted(path.stem for path in BUILTIN.glob("*.toml"))


def load_scenario(source: AnyScenario, changes: Changes | None = None) -> Scenario:
    """A built-in scenario, a TOML file, or what would stand in one; ``changes`` by dotted key.

    A scenario without changes is itself.

    Raises:
        UserError: no such scenario, or its text, a value or a change is not allowed.
    """
    changes = changes or {}
    if isinstance(source, Scenario):
        if not changes:
            return source
        source = source.model_dump(mode="json", exclude_none=True)
    if isinstance(source, Mapping):
        data = changed({"name": "scenario"} | dict(source), changes)
        return scenario_of(data, "scenario", Path())
    if not isinstance(source, str | Path):
        raise UserError(f"a {type(source).__name__} is no scenario, nor the name of one")
    name = str(source)
    built_in = name in builtin_names()
    path = BUILTIN / f"{name}.toml" if built_in else Path(name)
    if not exists(path) or path.is_dir():  # it may be the end of a pipe
        known = ", ".join(builtin_names())
        raise UserError(f"{name}: no such scenario; built in are {known}, or give a TOML file")
    data = read_toml(path)
    own = data.get("reference", {})
    if built_in and "file" in own:  # a file in a change lies where the user is
        own["file"] = str(BUILTIN / own["file"])
    return scenario_of(changed({"name": Path(name).stem} | data, changes), name, Path(name).parent)


def scenario_of(data: Any, source: str | Path, folder: Path) -> Scenario:
    """The scenario in ``data``, which a file in ``folder`` says.

    Raises:
        UserError: its text or a value is not allowed.
    """

    def beside(name: str) -> Design:
        path = folder / name
        return named_design(str(path) if exists(path) else name)

    return checked(Scenario, data, source, folder, named_design=beside)


def renamed(scenario: Scenario, name: Callable[[str, Path], Path]) -> Scenario:
    """The scenario with other paths, ``name(key, file)``, to the files that it names."""
    changes = _renamed_parts(scenario, "", name)
    each = [(own, _renamed_parts(own, f"{own.name}-", name)) for own in scenario.motions]
    if any(parts for _, parts in each):
        changes["motions"] = tuple(own.model_copy(update=parts) for own, parts in each)
    return scenario.model_copy(update=changes)


def _renamed_parts(own: Any, head: str, name: Callable[[str, Path], Path]) -> dict[str, Any]:
    """What a scenario or a motion follows and carries, where files are named in it."""
    changes = {key: _renamed(getattr(own, key), head + key, name) for key in ("reference", "load")}
    return {key: record for key, record in changes.items() if record is not None}


def _renamed(record: Any, key: str, name: Callable[[str, Path], Path]) -> Any:
    """The record with other paths, those of its axes too; None where it has none."""
    changes: dict[str, Any] = {}
    if (file := getattr(record, "file", None)) is not None:
        changes["file"] = name(key, file)
    axes = getattr(record, "axes", {})
    each = {axis: _renamed(own, f"{key}-{axis}", name) for axis, own in axes.items()}
    if found := {axis: own for axis, own in each.items() if own is not None}:
        changes["axes"] = {**axes, **found}
    return record.model_copy(update=changes) if changes else None


def scenario_toml(scenario: Scenario) -> str:
    """The scenario in full as TOML, every default spelled out."""
    return tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True))
