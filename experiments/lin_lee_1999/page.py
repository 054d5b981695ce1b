"""Figures and tables of the page of Lin & Lee 1999 (LL); see README.md beside this file.

First hfc batch experiments/lin_lee_1999/batch.toml, then python -m experiments.lin_lee_1999.page.
"""

from functools import partial
from pathlib import Path
from urllib.parse import unquote

import click
import numpy as np
from matplotlib.figure import Figure

from experiments.lin_lee_1999 import pictures
from experiments.lin_lee_1999.pictures import SEVEN, SIX, Case
from experiments.shared import HEAD, Batch, markdown
from hfc_design.batch.findings import grouped, winners
from hfc_design.batch.summary import winner_table
from hfc_design.cli.usage import Plain
from hfc_design.core.checkpoint import write_whole
from hfc_design.plotting.files import small_address
from hfc_design.plotting.numbers import score

#: Every case by the letters of its figures.
PARTS = {"05": lambda batch: pictures.code()} | {
    f"0{case.figure}{letter}": draw
    for case in (SIX, SEVEN)
    for letter, draw in (
        ("a", partial(pictures.convergence, case=case)),
        ("b", lambda batch, case=case: pictures.tree(case)),
        ("c-f", partial(pictures.motion, case=case)),
    )
}
MOTION = (
    "controller",
    "fitness",
    "rms error [mrad]",
    "largest [mrad]",
    "voltage [V]",
    "stick events",
)


@click.command(cls=Plain)
@click.option("--runs", default="runs/lin-lee-1999", type=click.Path(path_type=Path))
def main(runs: Path) -> None:
    """Draw the figures into the folder of the batch and print the tables."""
    batch = Batch(runs)
    for name, draw in PARTS.items():
        write_whole(runs / f"fig-{name}.svg", small(draw(batch)).encode())
    parts = [markdown(HEAD, batch.published()), motions(batch, SIX), motions(batch, SEVEN)]
    click.echo("\n".join([*parts, structures(batch)]), nl=False)


def small(figure: Figure) -> str:
    """The SVG with curves to a hundredth of a point."""
    return unquote(small_address(figure).partition(",")[2])


def motions(batch: Batch, case: Case) -> str:
    """What figs. 6 and 7, c to f, are read for: errors and voltage after the first second."""
    rows = []
    for name, one in pictures.shown(batch, case).items():
        axis, late = one.axes[0], one.time >= 1.0
        error, voltage = 1e3 * axis.motion.error[late], axis.motion.command[late]
        told = [f"{np.sqrt(np.mean(error**2)):.3g}", f"{np.abs(error).max():.3g}"]
        span = f"{voltage.min():.3g} to {voltage.max():.3g}"
        rows.append([name, score(one.fitness), *told, span, f"{one.metrics['stick_events']:.0f}"])
    return markdown(MOTION, rows)


def structures(batch: Batch) -> str:
    """Which hierarchies the searches ended with."""
    found = winners(grouped(batch.runs))
    named = zip(found, winner_table(found).rows, strict=True)
    rows = [[one.group.label.partition(": ")[2], row[0], *row[2:]] for one, row in named]
    return markdown(("search", "structure", "runs", "share [%]", "best", "median"), rows)


if __name__ == "__main__":
    main()
