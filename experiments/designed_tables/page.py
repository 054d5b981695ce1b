"""Designed controllers of a feed drive on paths that no search saw, beside the published ones.

hfc batch experiments/designed_tables/batch.toml         # first, some minutes
python -m experiments.designed_tables.page
"""

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import click
import numpy as np

from experiments.shared import Batch, markdown
from experiments.steps import Ranged, figures
from hfc_design.cli.usage import Plain
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario

PUBLISHED = {
    "FLC of 2004": "jee-koren-2004-flc",
    "AFLC of 2004": "jee-koren-2004-aflc",
    "PID of 2004": "jee-koren-2004-pid",
}
DESIGNED = {"flc": "designed FLC", "aflc": "designed AFLC", "pd+hierarchical-fuzzy": "hierarchy"}
FIRST = "simulation.duration_s=20.0"
#: Path -> changes of the scenario feed-drive-circle; 754 mm/min take 20 s for a cycle of R 40.
PATHS = {
    "circle R 40, 754 mm/min, three cycles": (),
    "the same, first cycle": (FIRST,),
    "circle R 15, 300 mm/min, clockwise": (
        "reference={kind='circle', radius_mm=15.0, feed_mm_min=300.0, direction='cw'}",
        FIRST,
    ),
    "line at 26.6 deg, 600 mm/min": (
        "reference={kind='line', length_mm=100.0, angle_deg=26.6, feed_mm_min=600.0}",
        "simulation.duration_s=10.0",
    ),
    "line to and fro, 450 mm/min": (
        "reference={kind='polyline', points_mm=[[0.0, 0.0], [40.0, -60.0], [0.0, 0.0]], "
        "feed_mm_min=450.0}",
        FIRST,
    ),
    "circle R 40, a machine with K = 28.3": ("plant.parameters.gain=28.3",),
    "circle R 40, a machine with F_c = 8": ("plant.parameters.coulomb=8.0",),
}
KEYS = ("rms_contour_error_BLU", "worst_glitch_BLU")
HEADER = ("path", "controller", "contour RMS [BLU]", "worst glitch [BLU]")


def candidates(batch: Path) -> dict[str, list[Design]]:
    """The published designs and those of the batch's finished cells, by what they are called."""
    found = defaultdict(list)
    for name, design in PUBLISHED.items():
        found[name].append(load_design(design))
    for run in Batch(batch).runs:
        design = load_design(str(batch / run.path))
        found[DESIGNED[design.controller.kind]].append(design)
    return found


def line(path: str, name: str, designs: list[Design], scenario: Scenario) -> list[str]:
    """A row: of one design a figure or its range over steps, of several their median and ends."""
    metrics = [figures(design, scenario) for design in designs]
    cells = []
    for key in KEYS:
        found = [item[key] for item in metrics if key in item]
        if not found:  # no axis reverses
            cells.append("-")
        elif len(found) == 1:
            cells.append(f"{found[0]:.2f}")
        else:
            middle = Ranged.of(*(np.median(x) for x in _columns(found)))
            ends = min(x.low for x in found), max(x.high for x in found)
            cells.append(f"{middle:.2f} ({ends[0]:.2f} to {ends[1]:.2f})")
    return [path, name, *cells]


def _columns(found: list[Ranged]) -> Iterable[tuple[float, ...]]:
    """The figures, and the lowest and the highest of each."""
    return zip(*((float(x), x.low, x.high) for x in found), strict=True)


def table(batch: Path) -> str:
    """Every controller on every path."""
    found = candidates(batch)
    rows = []
    for path, changes in PATHS.items():
        scenario = load_scenario("feed-drive-circle", changes)
        rows += [line(path, name, designs, scenario) for name, designs in found.items()]
    return markdown(HEADER, rows)


@click.command(cls=Plain)
@click.option("--runs", default="runs/designed-tables", type=click.Path(path_type=Path))
def main(runs: Path) -> None:
    """Print the table of the page."""
    click.echo(table(runs))


if __name__ == "__main__":
    main()
