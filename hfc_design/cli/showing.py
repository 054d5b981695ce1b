"""``hfc list``, ``show`` and ``init``: available things, with units and defaults. Starts no JAX."""

from pathlib import Path

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, argument, command, option
from hfc_design.cli.names import CONTROLLER, ENTRY_POINTS, OF_KIND, PLANT, OrElse

#: Kinds that can be shown; the first four may be a user's own.
KINDS = (*ENTRY_POINTS, "scenario", "design", "reference", "metric", "format", "key")
#: Names of hfc list -> kinds of the reference.
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
SINGULARS = {
    other: what
    for what, kind in LISTED.items()
    for other in (kind, *(many for many, one in PLURALS.items() if one == kind and many != what))
}


@command(name="list", last=common.KNOWING, no_args_is_help=True)
def list_(what: str = argument(OrElse(LISTED, SINGULARS), metavar="WHAT")) -> None:
    """What is built in.

    WHAT is one of scenarios, designs, plants, controllers, fitnesses, strategies and formats.
    """
    from hfc_design.cli import show_reference, show_tables

    if what == "plants":
        Answer(None, show_tables.plants).print(as_json=False)
    else:
        show_reference.show(LISTED[what], None).print(as_json=False)


@command(
    "Explain a plant, controller, scenario or key, with units.",
    last=common.KNOWING,
    no_args_is_help=True,
)
def show(
    kind: str = argument(OrElse(KINDS, PLURALS), metavar="KIND"),
    name: str | None = argument(OF_KIND, required=False),
) -> Answer:
    """Explain NAME: parameters, units, defaults, allowed values, sources of the equations.

    KIND is plant, controller, strategy, objective, scenario, design, reference, metric, format or
    key; without NAME all of that kind are listed. A scenario or design may be a file, a plug-in
    module:OBJECT; a key is one of a scenario, as in simulation.duration_s, or a table of keys. A
    scenario is shown with the values that it sets and the defaults of all other keys.
    """
    from hfc_design.cli import show_reference

    return show_reference.show(kind, name)


PLANT_HELP = "Plant: NAMES, or your own as module:OBJECT [default: c-axis]."
KIND_HELP = "Kind of controller: NAMES, or your own [default: pd+hierarchical-fuzzy]."


@command("Write a scenario to start from, every key explained.", last=common.plugins({}))
def init(
    plant: str = option(PLANT_HELP, kind=PLANT, default="c-axis"),
    controller: str = option(KIND_HELP, kind=CONTROLLER, default="pd+hierarchical-fuzzy"),
    out: Path | None = common.output("TOML file to write [default: PLANT.toml]."),
) -> None:
    """Write a scenario to start from: a move of a plant, every other key commented out.

    Each key has its default, unit, meaning and allowed values. hfc design FILE searches with the
    file unchanged; with a plug-in: hfc design FILE --use module:OBJECT.
    """
    from hfc_design.cli.show_reference import unlisted
    from hfc_design.core.checkpoint import write_whole
    from hfc_design.reference.beginning import beginning
    from hfc_design.reference.entries import units_of

    plants, controllers = unlisted("plant", plant), unlisted("controller", controller)
    plant = plants[0].name if plants else plant
    controller = controllers[0].name if controllers else controller
    text = beginning(plant, controller, [*plants, *controllers])
    _check_ranges(controller, plant, units_of(plant, plants))
    path = out or common.free(Path(f"{plant}.toml"))
    write_whole(path, text.encode())
    click.echo(path)


def _check_ranges(controller: str, plant: str, units: dict[str, str]) -> None:
    """Check that a kind of controller has search ranges for a plant; UserError: it has none."""
    from hfc_design.controllers.gains import GainsSettings
    from hfc_design.controllers.kinds import KINDS
    from hfc_design.core.records import UserError

    settings = KINDS.get(controller).settings
    if isinstance(settings, type) and issubclass(settings, GainsSettings):
        defaults = settings.model_construct(kind=controller)
        counted = f"(errors in {units.get('error', '?')}, commands in {units.get('command', '?')})"
        if lacking := defaults.lacking(plant, counted):
            raise UserError(f"--controller {controller}: {lacking}")
