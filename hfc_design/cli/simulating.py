"""Commands on one design and one scenario: score, simulate."""

import json
from pathlib import Path
from typing import Any

import click

from hfc_design.cli.options import SET_HELP, changing_design, loaded
from hfc_design.cli.plugin_options import choosing_plugins


@click.command()
@click.argument("design")
@changing_design
@click.option("--scenario", help="Scenario to run it on [default: the one it was made for].")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
@click.option("--spread", type=float, help="Vary the machine's parameters by up to this share.")
@click.option("--samples", type=int, help="Machines to draw [default: 1000].")
@click.option("--seed", type=int, help="Seed of the draw [default: 0].")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the metrics' distributions.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
@choosing_plugins
def score(
    design: str,
    others: tuple[str, ...],
    scenario: str | None,
    changes: tuple[str, ...],
    chosen: dict[str, str],
    spread: float | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Fitness, merit and metrics of DESIGN (a built-in name, a design file or a run folder).

    With --spread 0.2 on many machines, each physical parameter within 20 % of its value: the
    share that is stable, and quantiles of every metric. Stable is a motion that stays finite and
    in whose last quarter no error is larger than the reference ever is and no drive stands at a
    limit of its command for more than a tenth of the time.
    """
    from hfc_design.core.records import UserError
    from hfc_design.simulation.evaluation import evaluate

    given = {name: value for name, value in options.items() if value is not None}
    if spread is None and given:
        raise UserError(f"--{next(iter(given))} needs --spread, as in --spread 0.2")
    found, where = loaded(design, others, scenario, chosen, changes)
    if spread is not None:
        from hfc_design.cli.spread import score_spread

        score_spread(found, where, spread, as_json, **given)
        return
    evaluation = evaluate(found, where)
    if as_json:
        line = {
            "design": found.name,
            "scenario": where.name,
            "diverged": evaluation.diverged,
            **evaluation.score(where.judge()),
        }
        click.echo(json.dumps(line))
    else:
        from hfc_design.cli.terminal import show_table

        click.echo(f"scenario {where.name}")
        show_table(where, {found.name: evaluation})


@click.command()
@click.argument("design")
@changing_design
@click.option("--scenario", help="Scenario to run it on [default: the one it was made for].")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
@click.option("--csv", "csv_file", type=click.Path(path_type=Path), help="Write the trajectory.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw it (png, svg or pdf).")
@choosing_plugins
def simulate(
    design: str,
    others: tuple[str, ...],
    scenario: str | None,
    changes: tuple[str, ...],
    chosen: dict[str, str],
    csv_file: Path | None,
    plot: Path | None,
) -> None:
    """Simulate DESIGN and write its trajectory; without --csv or --plot to stdout as CSV."""
    from hfc_design.simulation.evaluation import evaluate, trajectory_csv

    found, where = loaded(design, others, scenario, chosen, changes)
    evaluation = evaluate(found, where)
    if plot is not None:
        from hfc_design.pictures.figure import save
        from hfc_design.report.contour_plots import motion

        save(motion(evaluation, f"{found.name} on {where.name}"), plot)
    if csv_file is not None:
        from hfc_design.core.checkpoint import write_whole

        write_whole(csv_file, trajectory_csv(evaluation).encode())
    if csv_file is None and plot is None:
        click.echo(trajectory_csv(evaluation), nl=False)
