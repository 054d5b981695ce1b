"""``hfc show``: what there is, with units, defaults and what is allowed. Starts no JAX."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli.options import NamedOfKind, OrElse, as_json, knowing_plugins

if TYPE_CHECKING:
    from hfc_design.reference.entries import Entry

#: What can be shown; the first four may be a user's own.
PLUGINS = {
    "plant": "hfc_design.plants",
    "controller": "hfc_design.controllers",
    "strategy": "hfc_design.strategies",
    "objective": "hfc_design.fitness",
}
KINDS = (*PLUGINS, "scenario", "design", "reference", "metric", "format", "key")
#: What hfc list lists -> kind of it in the reference.
LISTED = {
    "scenarios": "scenario",
    "designs": "design",
    "plants": "plant",
    "controllers": "controller",
    "fitnesses": "objective",
    "strategies": "strategy",
    "formats": "format",
}
PLURALS = {f"{kind}s": kind for kind in KINDS} | LISTED | {"fitness": "objective"}


@click.command(short_help="What a plant, controller, scenario or key is, with units.")
@click.argument("kind", metavar="KIND", type=OrElse(KINDS, PLURALS))
@click.argument("name", required=False, type=NamedOfKind())
@as_json
@knowing_plugins
def show(kind: str, name: str | None, as_json: bool) -> None:
    """What NAME is: its parameters, units, defaults, what is allowed, where the equations are from.

    KIND is one of plant, controller, strategy, objective, scenario, design, reference, metric,
    format and key; without NAME all of that kind are listed. A scenario or design may be a file,
    an own part module:OBJECT; a key is one of a scenario, as in simulation.duration_s, or a table
    of them. Of a scenario it says what it sets, beside the defaults that hold elsewhere.
    """
    from hfc_design.reference.entries import parts, things

    if name is None:
        _list(kind, listed(kind), as_json)
    elif kind == "scenario":
        _scenario(name, as_json)
    elif kind == "design":
        _design(name, as_json)
    elif kind == "key":
        _keys(name, as_json)
    else:
        head = [one for one in things(kind) if one.name == name]
        every = [*head, *parts(kind, name)] if head else _own(kind, name)
        if as_json:
            _print([one._asdict() for one in every])
        else:
            from hfc_design.cli.show_tables import show_thing

            show_thing(every)


def listed(kind: str) -> list["Entry"]:
    """Everything of a kind: what is built in, then what is installed or was made known here."""
    from hfc_design.reference.entries import things

    return [*things(kind), *(_own(kind, name)[0] for name in _own_names(kind))]


def _own(kind: str, name: str) -> list["Entry"]:
    """The entries of a user's own part; UserError: there is none of that name."""
    from hfc_design.reference.entries import METRIC, entries, things, unknown

    if kind in PLUGINS and (":" in name or name in _own_names(kind)):
        from hfc_design.gather.gather import live

        return live(kind, name)
    known = [one.name for one in things(kind)]
    if kind == METRIC:  # those of tables are of a plant's, with its units
        own = {one.key: one for one in entries() if one.part == METRIC}
        if name in own:
            return [own[name]._replace(kind=kind, name=name, part="", key="")]
        known += own
    raise unknown(kind, name, known, [one.name for one in things(kind)])


def _own_names(kind: str) -> list[str]:
    """Names of what is not built in: parts of installed packages, and those of --use."""
    if kind not in PLUGINS:
        return []
    from importlib import metadata

    from hfc_design.core.plugins import GROUPS

    group = GROUPS.get("fitness" if kind == "objective" else kind)
    known = [name for name in group.known if name not in group.built_in] if group else []
    return list(dict.fromkeys([*known, *metadata.entry_points(group=PLUGINS[kind]).names]))


def _print(data: Any) -> None:
    click.echo(json.dumps(data, ensure_ascii=False))


def _list(kind: str, found: list["Entry"], as_json: bool) -> None:
    if as_json:
        _print([one._asdict() for one in found])
        return
    from hfc_design.cli.show_tables import show_list

    show_list(kind, found)


def _keys(name: str, as_json: bool) -> None:
    """A key, wherever it is from, or all of a table that are of every plant, kind and so on."""
    from hfc_design.reference.entries import DESIGN_KEY, KEY, entries, unknown

    every = [one for one in entries() if one.part in ("", "setting", "parameter") and one.key]
    every = [one for one in every if one.kind != DESIGN_KEY]
    found = [one for one in every if one.key == name or one.key.startswith(f"{name}.")]
    if not found:
        known = list(dict.fromkeys(one.key for one in every))
        tables = dict.fromkeys(key for key in known if "." not in key)
        raise unknown("key", name, known, [*tables])
    general = [one for one in found if one.kind == KEY]
    _list("key", found if as_json or not general else general, as_json)
    if as_json or not general:
        return
    from hfc_design.cli.show_tables import show_owners

    show_owners(one for one in found if one.kind != KEY)


def _scenario(name: str, as_json: bool) -> None:
    from hfc_design.core.texts import no_such, read_toml
    from hfc_design.reference.entries import (
        NAMED,
        SCENARIO,
        check_keys,
        chosen,
        scenario_keys,
        things,
    )
    from hfc_design.reference.told import motions, values

    built_in = [one.name for one in things(SCENARIO)]
    if name not in built_in and not Path(name).is_file():
        raise no_such("scenario", name, built_in)
    place = Path(__file__).parents[1] / "files" / "scenarios"
    data = read_toml(place / f"{name}.toml" if name in built_in else name)
    own = [one for kind, thing in chosen(data).items() for one in unlisted(kind, thing)]
    known = scenario_keys(data, own)
    check_keys(data, known, name)
    found, each = values(data, known, own), list(motions(data))
    if as_json:
        named = {kind: chosen(data)[kind] for kind in NAMED.values()}
        rows = [one._asdict() for one in found]
        inside = {motion: [one._asdict() for one in told] for motion, told in each}
        _print({"name": name, "names": named, "keys": rows, "motions": inside})
        return
    from hfc_design.cli.show_tables import show_scenario

    show_scenario(name, data, found, each)


def unlisted(kind: str, name: str) -> list["Entry"]:
    """The entries of what a scenario names and the reference has not: an own part."""
    from hfc_design.reference.entries import things

    return [] if any(one.name == name for one in things(kind)) else _own(kind, name)


def _design(name: str, as_json: bool) -> None:
    from hfc_design.core.texts import no_such
    from hfc_design.files.design import named_design
    from hfc_design.reference.entries import DESIGN, things

    built_in = [one.name for one in things(DESIGN)]
    if name not in built_in and not Path(name).exists():
        raise no_such("design", name, built_in)
    from hfc_design.cli.show_design import facts, show_design

    found = facts(named_design(name))
    if as_json:
        _print(found)
    else:
        show_design(found)
