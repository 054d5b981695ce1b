"""What ``hfc show`` and ``hfc list`` tell: from the reference, or of a user's own parts."""

import json
from importlib import metadata
from pathlib import Path
from typing import Any

import click

from hfc_design.cli.names import ENTRY_POINTS
from hfc_design.cli.show_tables import show_list, show_owners, show_scenario, show_thing
from hfc_design.core.plugins import GROUPS
from hfc_design.core.texts import no_such, read_toml
from hfc_design.reference import entries as reference
from hfc_design.reference.entries import Entry
from hfc_design.reference.told import motions, values


def show(kind: str, name: str | None, as_json: bool) -> None:
    """``hfc show``: all of a kind, or what ``name`` is.

    Raises:
        UserError: there is nothing of that name.
    """
    if name is None:
        _list(kind, listed(kind), as_json)
    elif kind == "scenario":
        _scenario(name, as_json)
    elif kind == "design":
        _design(name, as_json)
    elif kind == "key":
        _keys(name, as_json)
    else:
        head = [one for one in reference.things(kind) if one.name == name]
        every = [*head, *reference.parts(kind, name)] if head else _own(kind, name)
        if as_json:
            _print([one._asdict() for one in every])
        else:
            show_thing(every)


def listed(kind: str) -> list[Entry]:
    """Everything of a kind: what is built in, then what is installed or was made known here."""
    return [*reference.things(kind), *(_own(kind, name)[0] for name in _own_names(kind))]


def _own(kind: str, name: str) -> list[Entry]:
    """The entries of a user's own part; UserError: there is none of that name."""
    if kind in ENTRY_POINTS and (":" in name or name in _own_names(kind)):
        from hfc_design.gather.gather import live

        return live(kind, name)
    known = [one.name for one in reference.things(kind)]
    if kind == reference.METRIC:  # those of tables are of a plant's, with its units
        own = {one.key: one for one in reference.entries() if one.part == reference.METRIC}
        if name in own:
            return [own[name]._replace(kind=kind, name=name, part="", key="")]
        known += own
    raise reference.unknown(kind, name, known, [one.name for one in reference.things(kind)])


def _own_names(kind: str) -> list[str]:
    """Names of what is not built in: parts of installed packages, and those of --use."""
    if kind not in ENTRY_POINTS:
        return []
    group = GROUPS.get("fitness" if kind == "objective" else kind)
    known = [name for name in group.known if name not in group.built_in] if group else []
    return list(dict.fromkeys([*known, *metadata.entry_points(group=ENTRY_POINTS[kind]).names]))


def _print(data: Any) -> None:
    click.echo(json.dumps(data, ensure_ascii=False))


def _list(kind: str, found: list[Entry], as_json: bool) -> None:
    if as_json:
        _print([one._asdict() for one in found])
        return
    show_list(kind, found)


def _keys(name: str, as_json: bool) -> None:
    """A key, wherever it is from, or all of a table that are of every plant, kind and so on."""
    every = [
        one for one in reference.entries() if one.part in ("", "setting", "parameter") and one.key
    ]
    every = [one for one in every if one.kind != reference.DESIGN_KEY]
    found = [one for one in every if one.key == name or one.key.startswith(f"{name}.")]
    if not found:
        known = list(dict.fromkeys(one.key for one in every))
        tables = dict.fromkeys(key for key in known if "." not in key)
        raise reference.unknown("key", name, known, [*tables])
    general = [one for one in found if one.kind == reference.KEY]
    _list("key", found if as_json or not general else general, as_json)
    if as_json or not general:
        return
    show_owners(one for one in found if one.kind != reference.KEY)


def _scenario(name: str, as_json: bool) -> None:
    built_in = [one.name for one in reference.things(reference.SCENARIO)]
    if name not in built_in and not Path(name).is_file():
        raise no_such("scenario", name, built_in)
    place = Path(__file__).parents[1] / "files" / "scenarios"
    data = read_toml(place / f"{name}.toml" if name in built_in else name)
    own = [one for kind, thing in reference.chosen(data).items() for one in unlisted(kind, thing)]
    known = reference.scenario_keys(data, own)
    reference.check_keys(data, known, name)
    found, each = values(data, known, own), list(motions(data))
    if as_json:
        named = {kind: reference.chosen(data)[kind] for kind in reference.NAMED.values()}
        rows = [one._asdict() for one in found]
        inside = {motion: [one._asdict() for one in told] for motion, told in each}
        _print({"name": name, "names": named, "keys": rows, "motions": inside})
        return
    show_scenario(name, data, found, each)


def unlisted(kind: str, name: str) -> list[Entry]:
    """The entries of what a scenario names and the reference has not: an own part."""
    return [] if any(one.name == name for one in reference.things(kind)) else _own(kind, name)


def _design(name: str, as_json: bool) -> None:
    built_in = [one.name for one in reference.things(reference.DESIGN)]
    if name not in built_in and not Path(name).exists():
        raise no_such("design", name, built_in)
    from hfc_design.cli.show_design import facts, show_design  # with every kind of controller
    from hfc_design.files.design import named_design

    found = facts(named_design(name))
    if as_json:
        _print(found)
    else:
        show_design(found)
