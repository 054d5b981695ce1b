"""``hfc design``."""

from pathlib import Path
from typing import Any

import click

from hfc_design.cli.options import SET_HELP
from hfc_design.cli.plugin_options import choosing_plugins


@click.command()
@click.argument("scenario", required=False)
@click.option("--out", type=click.Path(path_type=Path), help="Run folder [default: runs/NAME-N].")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of the search [default: 0].")
@click.option("--population", type=int, help="Individuals in a generation.")
@click.option("--generations", type=int, help="Generations.")
@click.option("--preset", help="Search strategy [default: race]; see hfc list strategies.")
@click.option("--precision", type=click.Choice(["float32", "float64"]), help="Of the search.")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
@click.option("--resume", is_flag=True, help="Continue the run in --out where it stopped.")
@click.option("--quiet", is_flag=True, help="No progress.")
@choosing_plugins
def design(
    scenario: str | None,
    out: Path | None,
    changes: tuple[str, ...],
    resume: bool,
    quiet: bool,
    chosen: dict[str, str],
    **options: Any,
) -> None:
    """Search a controller for SCENARIO (a built-in name or a TOML file).

    Without arguments: the no-load ramp of the C-axis.
    """
    from hfc_design.cli import search_run

    keys = {
        "seed": "run.seed",
        "population": "search.population",
        "generations": "search.generations",
        "preset": "search.preset",
        "precision": "run.precision",
    }
    given = [f"{keys[name]}={value}" for name, value in options.items() if value is not None]
    plugins = () if resume else chosen.values()  # they only have to be known then
    search_run.design(scenario, out, [*plugins, *given, *changes], resume, quiet)
