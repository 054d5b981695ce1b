"""Figures and tables of the page of Huang & Shy; see README.md beside this file.

First hfc batch experiments/huang_shy/batch.toml, then python -m experiments.huang_shy.page.
"""

from pathlib import Path

import click

from experiments.huang_shy import pictures
from experiments.huang_shy.tables import axes, draws, laps, learning, machines
from experiments.shared import HEAD, Batch, markdown
from hfc_design.cli.usage import Plain
from hfc_design.plotting.files import save

PARTS = {
    "02-04": pictures.circle,
    "03": pictures.sine,
    "05-08": pictures.axes,
    "09-10": pictures.small_circle,
    "11": pictures.milling,
    "laps": pictures.laps,
}


@click.command(cls=Plain)
@click.option("--runs", default="runs/huang-shy", type=click.Path(path_type=Path))
@click.option("--comparison", type=click.Path(path_type=Path), help="comparison.csv of hfc compare")
def main(runs: Path, comparison: Path | None) -> None:
    """Draw the figures into the folder of the batch and print the tables."""
    batch = Batch(runs)
    for name, draw in PARTS.items():
        save(draw(batch), runs / f"fig-{name}.svg")
    rows = [*batch.published(), *axes(batch), *learning(batch)]
    parts = [markdown(HEAD, rows), draws(), laps(batch)]
    if comparison is not None:
        parts.append(machines(comparison))
    click.echo("\n".join(parts), nl=False)


if __name__ == "__main__":
    main()
