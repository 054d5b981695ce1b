"""``hfc compare``: designs side by side, as tables, as a page, as data."""

import json
import sys
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, Texts, argument, command, option
from hfc_design.cli.names import DESIGN, SCENARIO
from hfc_design.cli.options import Papers

if TYPE_CHECKING:
    from hfc_design.report.paper import Paper
    from hfc_design.simulation.comparison import Comparison

SCENARIO_HELP = (
    "Scenario to compare in; can be given several times [default: the first design's own]."
)
SPREAD_HELP = (
    "Relative spread of machine parameters [default: robust.spread and its tolerances, or 0.2]."
)
#: Files that ``--out`` writes into its folder.
PAGE, TABLE, NUMBERS = "report.html", "comparison.csv", "comparison.json"


def _shares(context: click.Context, option: click.Parameter, values: Texts) -> dict[str, float]:
    """Return parameter -> spread from texts as ``backlash=0.5``; BadParameter: another form."""
    from hfc_design.core.numbers import number_or_none

    shares = {}
    for value in values:
        name, _, share = value.partition("=")
        if (number := number_or_none(share)) is None:
            raise click.BadParameter(f"{value!r}: must be NAME=SHARE, as in backlash=0.5")
        if not 0.0 < number < 1.0:
            raise click.BadParameter(f"{value!r}: must be between 0 and 1")
        shares[name] = number
    return shares


@command("Compare DESIGNS on the same machines.", last=common.ON_A_PLANT)
def compare(
    designs: Texts = argument(DESIGN, nargs=-1),
    scenarios: Texts = option(SCENARIO_HELP, "--scenario", kind=SCENARIO),
    changes: Texts = common.SETTING,
    spread: float | None = option(SPREAD_HELP),
    tolerances: dict[str, float] = option(
        "Relative spread of one parameter, as backlash=0.5; can be given several times.",
        "--tolerance",
        kind=click.STRING,
        multiple=True,
        metavar="PARAMETER=SHARE",
        callback=_shares,
    ),
    machines: int = option("Number of perturbed machines [default: 200].", low=1, default=200),
    seed: int = option("Random seed of the machines [default: 0].", low=0, default=0),
    out: Path | None = common.output("Folder for page, CSV and JSON.", folder=True),
    html: Path | None = common.output("Write only the page."),
    papers: Papers = common.PAPERS,
    plot: Path | None = common.output("Draw the errors on all machines."),
    csv: Path | None = common.output("Write a row for each design, motion and machine."),
    _force: bool = common.FORCE,
    _memory: str | None = common.MEMORY,
    _as_json: bool = common.AS_JSON,
) -> Answer:
    """Compare DESIGNS on the same machines: built-in names, design files, run folders.

    All run in the same scenarios, on the nominal machine and on the same perturbed machines, each
    physical parameter within --spread of its value, or within its --tolerance. The tables mark the
    best of each row, and compare the first design with every other machine by machine: median ratio
    and its interval, on how many machines it is better, and p of Wilcoxon's signed-rank test,
    corrected by Holm over all comparisons. A design loses on a machine that it does not keep
    stable. The page shows the motions too.
    """
    from hfc_design.core.console import MachinesBar
    from hfc_design.files.design_set import labelled
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.plotting.files import save
    from hfc_design.report.comparison.plots import machines as machines_drawn
    from hfc_design.report.comparison.tables import tables
    from hfc_design.simulation.comparison import compare

    if out is not None:
        paper = papers(out, "")
    else:
        paper = papers(*((html.parent, f"{html.stem}-") if html else (Path(), "comparison-")))
    every = (*common.choosing("plant"), *changes)
    if designs and not scenarios:
        first = next(iter(labelled(designs).values()))
        where = common.scenarios_of(first, designs[0], (), every)
    else:
        where = [load_scenario(name, every) for name in scenarios]
    begun = time.monotonic()
    with MachinesBar() as bar:
        comparison = compare(designs, where, spread, machines, seed, bar.chunk, tolerances)
    print(f"simulated in {time.monotonic() - begun:.1f} s", file=sys.stderr)
    options = _options(comparison, scenarios, changes)
    again = common.again(["hfc", "compare", *designs], options, comparison.designs.values())
    written = _written(comparison, again, {html: PAGE, csv: TABLE}, out, paper)
    if plot is not None:
        save(machines_drawn(comparison), plot)
        written.append(plot)
    return Answer(comparison.numbers(), partial(tables, comparison), written)


def _options(comparison: "Comparison", scenarios: Texts, changes: Texts) -> dict[str, Texts]:
    """Return option -> values for the command that repeats the comparison."""
    from hfc_design.files.machine import ALL_PLANTS

    plant = common.named_part("plant")
    return {
        "--scenario": scenarios,
        "--plant": (ALL_PLANTS.source(plant) or plant,) if plant else (),
        "--set": changes,
        "--spread": (f"{comparison.spread:g}",),
        "--tolerance": tuple(f"{name}={share:g}" for name, share in comparison.tolerances.items()),
        "--machines": (str(comparison.machines),),
        "--seed": (str(comparison.seed),),
    }


def _written(
    comparison: "Comparison",
    again: str,
    wanted: dict[Path | None, str],
    folder: Path | None,
    paper: "Paper | None",
) -> list[Path]:
    """Write the ``wanted`` files, all files into ``folder``, and a ``paper``; return the paths."""
    from hfc_design.core.checkpoint import write_whole
    from hfc_design.core.records import writing
    from hfc_design.formats.writing import csv_text
    from hfc_design.report.comparison.page import page
    from hfc_design.report.comparison.tables import rows

    drawn = cache(lambda: page(comparison, again))
    made: dict[str, Callable[[], str | bytes]] = {
        PAGE: lambda: drawn().html,
        TABLE: lambda: csv_text(rows(comparison)),
        NUMBERS: lambda: json.dumps(comparison.numbers(), indent=1) + "\n",
    }
    paths = {path: name for path, name in wanted.items() if path is not None}
    if folder is not None:
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        paths |= {folder / name: name for name in made}
    for path, name in paths.items():
        content = made[name]()
        write_whole(path, content.encode() if isinstance(content, str) else content)
    return [*paths, *(paper.write(drawn()) if paper else ())]
