"""``hfc show``: what there is, with units, defaults and what is allowed. Starts no JAX."""

import click

from hfc_design.cli.options import NamedOfKind, OrElse, as_json, knowing_plugins

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
    from hfc_design.cli import show_reference

    show_reference.show(kind, name, as_json)
