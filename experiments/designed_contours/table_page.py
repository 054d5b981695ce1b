"""The designed controller of the milling table beside the published ones, as tables.

The comparisons that the README names come first, each in a folder of its own.
python -m experiments.designed_contours.table_page runs/table-beside
"""

import csv
from collections import defaultdict
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from experiments.shared import markdown
from hfc_design.cli.usage import Plain
from hfc_design.core.statistics import paired

Floats = NDArray[np.float64]
#: What is compared: metric -> how it is called.
METRICS = {
    "path_error_mm": "path error",
    "worst_glitch_mm": "impulse",
    "rms_contour_error_mm": "rms",
}
CHATTER = "rms_voltage_change_V"
#: The designed one, by the name in its file.
OWN = "table"
MICRONS = 1e3
NOMINAL = ("motion", "controller", "path error / impulse / rms [um]", "chatter [V]")
PAIRED = ("motion", "against", "stable", *METRICS.values())


class Side:
    """One design in one motion, on the nominal machine and all others."""

    def __init__(self, rows: list[dict[str, str]]):
        self.values = {key: np.array([_number(row[key]) for row in rows]) for key in rows[0]}

    def nominal(self) -> str:
        """Path error, impulse and rms."""
        return " / ".join(f"{MICRONS * self.values[key][0]:.1f}" for key in METRICS)

    def kept(self) -> str:
        """Share of the machines that it keeps stable."""
        return f"{100 * np.mean(self.values['stable'][1:]):.3g} %"


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def sides(file: Path) -> dict[str, Side]:
    """Every design of a ``comparison.csv``, by its name."""
    found: dict[str, list[dict[str, str]]] = defaultdict(list)
    with file.open(newline="") as lines:
        for row in csv.DictReader(lines):
            found[row["design"]].append(row)
    return {name: Side(rows) for name, rows in found.items()}


def against(own: Side, other: Side, key: str) -> str:
    """On how many machines the first one has less, and the median of the ratios.

    Of the numbers alone: a design that oscillates has not lost by that.
    """
    mine, theirs = own.values[key][1:], other.values[key][1:]
    theirs = np.where(np.isnan(theirs), np.inf, theirs)  # diverged
    ratio, interval, _ = paired(np.log(mine) - np.log(theirs))
    low, high = interval or (np.nan, np.nan)
    return f"{(mine < theirs).sum()}, {ratio:.2f} ({low:.2f} to {high:.2f})"


def tables(folder: Path) -> tuple[str, str]:
    """Of the nominal machine, and paired over the others; a row each motion and design."""
    nominal, others = [], []
    for file in sorted(folder.glob("*.csv")):
        found, motion = sides(file), file.stem
        for name, side in found.items():
            nominal.append([motion, name, side.nominal(), f"{side.values[CHATTER][0]:.2f}"])
            kept = f"{found[OWN].kept()}, {side.kept()}"
            if name != OWN:
                each = [against(found[OWN], side, key) for key in METRICS]
                others.append([motion, name, kept, *each])
    return markdown(NOMINAL, nominal), markdown(PAIRED, others)


@click.command(cls=Plain)
@click.argument("folder", type=click.Path(path_type=Path, exists=True))
def main(folder: Path) -> None:
    """Print the tables of the page."""
    for table in tables(folder):
        click.echo(table + "\n")


if __name__ == "__main__":
    main()
