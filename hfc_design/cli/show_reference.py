"""Output of ``hfc show`` and ``hfc list``, from the reference or for a user's own parts."""

from collections.abc import Callable, Iterable
from importlib import metadata
from pathlib import Path
from typing import Any

from hfc_design.cli import show_tables
from hfc_design.cli.binding import Answer
from hfc_design.cli.names import ENTRY_POINTS
from hfc_design.core.plugins import GROUPS
from hfc_design.core.tables import Table, text
from hfc_design.core.texts import no_such, read_toml
from hfc_design.reference import entries as reference
from hfc_design.reference.entries import Entry
from hfc_design.reference.values import motions, values

SCENARIOS = Path(__file__).parents[1] / "files" / "scenarios"


def show(kind: str, name: str | None) -> Answer:
    """Return the output of ``hfc show``: all things of a kind, or the thing ``name``.

    Raises:
        UserError: there is nothing of that name.
    """
    if name is None:
        installed = [_plugin(kind, one)[0] for one in _plugins(kind)]
        return _list(kind, [*reference.things(kind), *installed])
    if kind == "scenario":
        return _scenario(name)
    if kind == "design":
        return _design(name)
    if kind == "key":
        return _keys(name)
    head = [one for one in reference.things(kind) if one.name == name]
    every = [*head, *reference.parts(kind, name)] if head else _plugin(kind, name)
    return _answer([one._asdict() for one in every], lambda: show_tables.thing(every))


def unlisted(kind: str, name: str) -> list[Entry]:
    """Return the entries of a user's own part; [] for a part that the reference contains."""
    return [] if name in _names(kind) else _plugin(kind, name)


def _names(kind: str) -> list[str]:
    return [one.name for one in reference.things(kind)]


def _plugin(kind: str, name: str) -> list[Entry]:
    """Return the entries of a user's own part; UserError: there is none of that name."""
    if kind in ENTRY_POINTS and (":" in name or name in _plugins(kind)):
        from hfc_design.schema.collect import live

        return live(kind, name)
    known = _names(kind)
    if kind == reference.METRIC:  # the reference lists metrics of tables under each plant
        of_plants = {one.key: one for one in reference.entries() if one.part == reference.METRIC}
        if name in of_plants:
            return [of_plants[name]._replace(kind=kind, name=name, part="", key="")]
        known += of_plants
    raise reference.unknown(kind, name, known, _names(kind))


def _plugins(kind: str) -> list[str]:
    """Return the names of parts that are not built in: from --use and from installed packages."""
    if kind not in ENTRY_POINTS:
        return []
    group = GROUPS.get("fitness" if kind == "objective" else kind)
    known = [name for name in group.known if name not in group.built_in] if group else []
    return list(dict.fromkeys([*known, *metadata.entry_points(group=ENTRY_POINTS[kind]).names]))


def _answer(numbers: Any, tables: Callable[[], Iterable[Table]]) -> Answer:
    return Answer(numbers, tables, ascii=False)


def _list(kind: str, entries: list[Entry]) -> Answer:
    data = [one._asdict() for one in entries]
    return _answer(data, lambda: [show_tables.listed(kind, entries)])


def _keys(name: str) -> Answer:
    """Show a key, or all keys of a table; of keys that only some things have, name the things."""
    every = [
        one
        for one in reference.entries()
        if one.part in ("", "setting", "parameter") and one.key and one.kind != reference.DESIGN_KEY
    ]
    below = [one for one in every if f"{one.key}.".startswith(f"{name}.")]
    if not below:
        known = list(dict.fromkeys(one.key for one in every))
        raise reference.unknown("key", name, known, [key for key in known if "." not in key])
    general = [one for one in below if one.kind == reference.KEY]
    others = show_tables.owners(one for one in below if one.kind != reference.KEY)
    shown = show_tables.listed("key", general or below)
    tables = [shown, text(*others)] if general and others else [shown]
    return _answer([one._asdict() for one in below], lambda: tables)


def _scenario(name: str) -> Answer:
    built_in = name in _names(reference.SCENARIO)
    if not built_in and not Path(name).is_file():
        raise no_such("scenario", name, _names(reference.SCENARIO))
    data = read_toml(SCENARIOS / f"{name}.toml" if built_in else name)
    chosen = reference.chosen(data)
    unlisted_entries = [one for kind, thing in chosen.items() for one in unlisted(kind, thing)]
    known = reference.scenario_keys(data, unlisted_entries)
    reference.check_keys(data, known, name)
    entries, each = values(data, known, unlisted_entries), list(motions(data))
    keys = [one._asdict() for one in entries]
    inside = {motion: [one._asdict() for one in rows] for motion, rows in each}
    numbers = {"name": name, "names": chosen, "keys": keys, "motions": inside}
    return _answer(numbers, lambda: show_tables.scenario(name, data, entries, each))


def _design(name: str) -> Answer:
    if name not in _names(reference.DESIGN) and not Path(name).exists():
        raise no_such("design", name, _names(reference.DESIGN))
    from hfc_design.cli.show_design import facts  # imports every kind of controller
    from hfc_design.files.design import named_design

    record = facts(named_design(name))
    return _answer(record, lambda: show_tables.design(record))
