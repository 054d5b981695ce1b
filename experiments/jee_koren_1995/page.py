"""Figures and tables of the page of Jee & Koren 1995 (JK95); see README.md beside this file.

First hfc batch experiments/jee_koren_1995/FILE for batch.toml and start-of-2004.toml, then
python -m experiments.jee_koren_1995.page.
"""

from math import sqrt
from pathlib import Path

import click
from matplotlib.figure import Figure

from experiments.shared import HEAD, Batch, calculated, chaotic, curves, markdown, number
from hfc_design.cli.usage import Plain
from hfc_design.plotting.files import save
from hfc_design.stability.stable_range import stable_range

CYCLES = tuple(f"cycle_{k}_rms_contour_error_BLU" for k in (1, 2, 3))
AXIAL = tuple(f"cycle_{k}_x_rms_error_BLU" for k in (1, 3))
LARGEST = "cycle_3_max_contour_error_BLU"
CONTOUR = "contour error [BLU]"
VARIANTS = ("circle of figs. 3 and 4", "FLC axial", "FLC contour", "SOFLC axial 1", "3",
            "SOFLC contour 1", "2", "3")  # fmt: skip
PAPER = ("the paper", "6.36 to 6.08", "1.87", "3.31", "1.82", "1.39", "1.24", "1.23")
#: The drive, and the circle of figs. 3 and 4.
GAIN, LAG, SAMPLE_TIME = 28.3, 0.055, 0.01
SPEED = 754.0 / 60.0 / 0.01  # [BLU/s]


def circle(batch: Batch) -> Figure:
    """Figs. 3 and 4: errors of the third cycle."""
    found = {name: batch.motion(name) for name in ("FLC", "SOFLC")}
    last = found["FLC"].time >= 40.0
    axial = "axial error X [BLU]"
    panels = {
        axial: {k: item.axes[0].motion.error[last] for k, item in found.items()},
        CONTOUR: {k: item.contour.error[last] for k, item in found.items()},
    }
    levels = {axial: {"RMS of the SOFLC in the paper": 1.82}}
    return curves(found["FLC"].time[last], panels, levels)


def stiction(batch: Batch) -> Figure:
    """Fig. 5: without and with compensation of stiction, the third cycle."""
    labels = {"without": "machine, SOFLC", "with compensation": "machine, SOFLC, compensation"}
    found = {name: batch.motion(label) for name, label in labels.items()}
    last = found["without"].time >= 40.0
    panel = {name: item.contour.error[last] for name, item in found.items()}
    return curves(found["without"].time[last], {CONTOUR: panel})


def line(batch: Batch) -> Figure:
    """Fig. 6: line y = 10 x."""
    found = {name: batch.motion(f"line, {name}") for name in ("FLC", "SOFLC")}
    panel = {name: item.contour.error for name, item in found.items()}
    return curves(found["FLC"].time, {CONTOUR: panel})


def further(batch: Batch) -> list[list[str]]:
    """What is a difference of runs, and what no run is needed for."""
    rows = []
    for name, feed in (("", "0.754 m/min"), ("slow, ", "0.377 m/min")):
        labels = (f"{name}machine, SOFLC", f"{name}machine, SOFLC, compensation")
        before, after = (batch.run(label).score[LARGEST] or 0.0 for label in labels)
        quantity = f"{feed}: largest contour error, less by compensation [BLU]"
        rows.append(calculated("5", quantity, 3.0, before - after, "real machine"))
    steepest = stable_range(GAIN, LAG, SAMPLE_TIME).k1_linear
    least = SPEED / (GAIN * steepest) / sqrt(2.0)
    limit = "axial RMS at the linear limit of the gain, no integral term [BLU]"
    rows.append(calculated("3", limit, None, least, "speed / (K K_1) / sqrt(2)"))
    return rows


def variants(batch: Batch, first: str) -> str:
    """What the paper leaves open does to the circle of figs. 3 and 4, from a label on."""
    labels = [run.settings["label"] for run in batch.runs]
    starts = [label for label in labels if label.startswith("FLC, ")]
    lines = [PAPER]
    for label in labels[labels.index(first) :]:
        if label in starts:
            continue
        own = (start for start in starts if label.startswith(start.removeprefix("FLC, ")))
        fixed = next(own, "FLC")
        values = batch.values(fixed, AXIAL[-1], CYCLES[-1]) + batch.values(label, *AXIAL, *CYCLES)
        lines.append((label, *(number(value, ".2f") for value in values)))
    return markdown(VARIANTS, lines)


PARTS = {"03-04": circle, "05": stiction, "06": line}


@click.command(cls=Plain)
@click.option("--runs", default="runs/jee-koren-1995", type=click.Path(path_type=Path))
def main(runs: Path) -> None:
    """Draw the figures into the folder of the batch and print the tables."""
    fit, older = Batch(runs), Batch(runs.with_name(f"{runs.name}-start-of-2004"))
    for name, draw in PARTS.items():
        save(draw(fit), runs / f"fig-{name}.svg")
    parts = [
        markdown(HEAD, [*fit.published(), *further(fit)]),
        variants(fit, "SOFLC"),
        chaotic(fit),
        markdown(HEAD, older.published()),
        variants(older, "as built in"),
        chaotic(older),
    ]
    click.echo("\n".join(parts), nl=False)


if __name__ == "__main__":
    main()
