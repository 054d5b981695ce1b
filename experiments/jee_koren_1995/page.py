"""Figure and tables of the page of Jee & Koren 1995 (JK95); see README.md beside this file.

First hfc batch experiments/jee_koren_1995/batch.toml, then
python -m experiments.jee_koren_1995.page.
"""

from pathlib import Path

import click

from experiments.shared import HEAD, Batch, curves, markdown, number
from hfc_design.pictures.figure import save

CYCLES = tuple(f"cycle_{k}_rms_contour_error_BLU" for k in (1, 2, 3))
AXIAL = tuple(f"cycle_{k}_x_rms_error_BLU" for k in (1, 3))
VARIANTS = ("circle of figs. 3 and 4", "FLC axial", "FLC contour", "SOFLC axial 1", "3",
            "SOFLC contour 1", "2", "3")  # fmt: skip
PAPER = ("the paper", "6.36 to 6.08", "1.87", "3.31", "1.82", "1.39", "1.24", "1.23")


def figure(batch: Batch, out: Path) -> None:
    """Figs. 3 and 4: errors of the third cycle."""
    found = {"FLC": batch.motion("FLC"), "SOFLC": batch.motion("as built in")}
    last = found["FLC"].time >= 40.0
    panels = {
        "axial error X [BLU]": {k: item.axes[0].motion.error[last] for k, item in found.items()},
        "contour error [BLU]": {k: item.contour.error[last] for k, item in found.items()},
    }
    levels = {"axial error X [BLU]": {"RMS of the SOFLC in the paper": 1.82}}
    save(curves(found["FLC"].time[last], panels, levels), out)


def variants(batch: Batch) -> str:
    """What the paper leaves open does to the circle of figs. 3 and 4."""
    labels = [run.settings["label"] for run in batch.runs]
    starts = [label for label in labels if label.startswith("FLC, ")]
    lines = [PAPER]
    for label in labels[labels.index("as built in") :]:
        if label in starts:
            continue
        own = (start for start in starts if label.startswith(start.removeprefix("FLC, ")))
        fixed = next(own, "FLC")
        values = batch.values(fixed, AXIAL[-1], CYCLES[-1]) + batch.values(label, *AXIAL, *CYCLES)
        lines.append((label, *(number(value, ".2f") for value in values)))
    return markdown(VARIANTS, lines)


@click.command()
@click.option("--runs", default="runs/jee-koren-1995", type=click.Path(path_type=Path))
def main(runs: Path) -> None:
    """Draw the figure into the folder of the batch and print the tables."""
    batch = Batch(runs)
    figure(batch, runs / "fig-03-04.svg")
    click.echo(markdown(HEAD, batch.published()))
    click.echo(variants(batch), nl=False)


if __name__ == "__main__":
    main()
