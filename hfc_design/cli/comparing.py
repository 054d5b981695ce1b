"""``hfc compare``: designs side by side, as tables, as a page, as data."""

import json
import sys
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, Texts, argument, command, option
from hfc_design.cli.functions import function
from hfc_design.cli.names import DESIGN, SCENARIO
from hfc_design.cli.reporting import PAPERS, paper_of

if TYPE_CHECKING:
    from hfc_design.report.paper import Paper
    from hfc_design.simulation.comparison import Comparison

SCENARIO_HELP = (
    "Scenario to compare in; can be given several times [default: the first design's own]."
)
SPREADS = option(None, "--tolerance", metavar="PARAMETER=SHARE")
#: Files that ``--out`` writes into its folder.
PAGE, TABLE, NUMBERS = "report.html", "comparison.csv", "comparison.json"


@command("Compare DESIGNS on the same machines.", last=common.ON_A_PLANT)
def compare(
    designs: Texts = argument(DESIGN, nargs=-1),
    scenarios: Texts = option(SCENARIO_HELP, "--scenario", kind=SCENARIO),
    changes: Texts = common.SETTING,
    call: "partial[Comparison]" = function(
        *("simulation.comparison.compare", "designs", "scenarios", "progress"), tolerances=SPREADS
    ),
    out: Path | None = common.output("Folder for page, CSV and JSON.", folder=True),
    html: Path | None = common.output("Write only the page."),
    papers: "partial[Paper | None]" = PAPERS,
    plot: Path | None = common.output("Draw the errors on all machines."),
    csv: Path | None = common.output("Write a row for each design, motion and machine."),
) -> Answer:
    """Compare DESIGNS on the same machines: built-in names, design files, run folders."""
    from hfc_design.core.console import MachinesBar
    from hfc_design.core.overrides import set_keys
    from hfc_design.files.design_set import labelled
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.plotting.files import save
    from hfc_design.report.comparison.plots import machines as machines_drawn
    from hfc_design.report.comparison.tables import tables

    place = (html.parent, f"{html.stem}-") if html else (Path(), "comparison-")
    paper = paper_of(papers, *place) if out is None else paper_of(papers, out)
    tolerances = set_keys(call.keywords["tolerances"], "tolerance")
    every = (*common.choosing("plant"), *changes)
    if designs and not scenarios:
        first = next(iter(labelled(designs).values()))
        where = common.scenarios_of(first, designs[0], (), every)
    else:
        where = [load_scenario(name, every) for name in scenarios]
    begun = time.monotonic()
    with MachinesBar() as bar:
        comparison = call(designs, where, progress=bar.chunk, tolerances=tolerances)
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
    from hfc_design.formats.writing import csv_text, write
    from hfc_design.report.comparison.page import page
    from hfc_design.report.comparison.tables import rows

    drawn = cache(lambda: page(comparison, again))
    made: dict[str, Callable[[], str | bytes]] = {
        PAGE: lambda: drawn().html,
        TABLE: lambda: csv_text(rows(comparison)),
        NUMBERS: lambda: json.dumps(comparison.numbers(), indent=1) + "\n",
    }
    paths = {path: name for path, name in wanted.items() if path is not None}
    for path, name in paths.items():
        write(path, made[name]())
    if folder is not None:
        write(folder, {name: make() for name, make in made.items()})
        paths |= {folder / name: name for name in made}
    return [*paths, *(paper.write(drawn()) if paper else ())]
