"""``hfc init``: a scenario to begin with. Starts no JAX but for a user's own parts."""

from pathlib import Path

import click

from hfc_design.cli.options import CONTROLLER, PLANT, force, free, named, output, with_plugins

PLANT_HELP = "Plant: NAMES, or an own one as module:OBJECT [default: c-axis]."
KIND_HELP = "Kind of controller: NAMES, or an own one [default: pd+hierarchical-fuzzy]."


@click.command(short_help="Write a scenario to begin with, every key explained.")
@named("--plant", kind=PLANT, default="c-axis", help=PLANT_HELP)
@named("--controller", kind=CONTROLLER, default="pd+hierarchical-fuzzy", help=KIND_HELP)
@output("--out", help="TOML file to write [default: PLANT.toml].")
@force
@with_plugins({})
def init(plant: str, controller: str, out: Path | None) -> None:
    """Write a scenario to begin with: a move of a plant, every other key commented out.

    Each key stands there with its default, unit and meaning and what is allowed. The file can be
    searched as it is, by hfc design FILE, with an own part by hfc design FILE --use module:OBJECT.
    """
    from hfc_design.cli.show_reference import unlisted
    from hfc_design.core.checkpoint import write_whole
    from hfc_design.reference.beginning import beginning
    from hfc_design.reference.entries import units_of

    own = {"plant": unlisted("plant", plant), "controller": unlisted("controller", controller)}
    names = [
        found[0].name if (found := own[kind]) else name
        for kind, name in (("plant", plant), ("controller", controller))
    ]
    text = beginning(names[0], names[1], [*own["plant"], *own["controller"]])
    _check_ranges(names[1], names[0], units_of(names[0], own["plant"] or None))
    path = out or free(Path(f"{names[0]}.toml"))
    write_whole(path, text.encode())
    click.echo(path)


def _check_ranges(controller: str, plant: str, units: dict[str, str]) -> None:
    """UserError: a search for such a controller has no ranges on the plant, in ``units``."""
    from hfc_design.controllers.gains import GainsSettings
    from hfc_design.controllers.kinds import KINDS
    from hfc_design.core.records import UserError

    settings = KINDS.get(controller).settings
    if isinstance(settings, type) and issubclass(settings, GainsSettings):
        own = settings.model_construct(kind=controller)
        counted = f"(errors in {units.get('error', '?')}, commands in {units.get('command', '?')})"
        if lacking := own.lacking(plant, counted):
            raise UserError(f"--controller {controller}: {lacking}")
