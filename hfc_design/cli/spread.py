"""``hfc score --spread``: one design on many machines."""

import json
import sys
import time
from pathlib import Path

from hfc_design.cli.terminal import progress_bar
from hfc_design.core.console import plain_table, terminal
from hfc_design.core.shapes import Json
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.monte_carlo import robustness


def score_spread(
    design: Design,
    scenario: Scenario,
    spread: float,
    as_json: bool,
    samples: int = 1000,
    seed: int = 0,
    plot: Path | None = None,
) -> None:
    """``hfc score --spread``: simulate, show progress on stderr, print, draw.

    Raises:
        UserError: a value is not allowed, or design and scenario do not fit.
    """
    console = terminal(stderr=True)
    bar = progress_bar(console)
    task = bar.add_task("compiling", total=samples + 1, line="machines")

    def progress(done: int, total: int) -> None:
        bar.update(task, description="simulating", completed=done, total=total)

    begun = time.monotonic()
    with bar:
        found = robustness(design, scenario, spread, samples, seed, progress)
    print(f"{samples} machines in {time.monotonic() - begun:.1f} s", file=sys.stderr)
    own = {"design": design.name, "scenario": scenario.name, "judged_by": scenario.judge().title}
    numbers = own | found.numbers()
    if as_json:
        print(json.dumps(numbers))
    else:
        _show_spread(numbers)
    if plot is not None:
        from hfc_design.pictures.figure import save
        from hfc_design.report.spread_plots import distributions

        save(distributions(found, f"{design.name} on {scenario.name}"), plot)


def _show_spread(numbers: Json) -> None:
    table = plain_table(
        title=f"{numbers['design']} on {numbers['scenario']}, "
        f"parameters +-{100 * numbers['spread']:g} %",
        title_style="",
        caption=f"{100 * numbers['stable_share']:.4g} % of {numbers['samples']} machines are "
        f"stable, the nominal one {'too' if numbers['nominal_stable'] else 'is not'}\n"
        f"quantiles of the stable ones that have the metric; merit is {numbers['judged_by']}\n"
        f"impossible machines drawn again: {numbers['refused_draws']}\n"
        f"simulated again with shorter steps: {numbers['refined']}",
        caption_justify="left",
    )
    table.add_column("metric", no_wrap=True)
    for name in ("nominal", "5 %", "25 %", "50 %", "75 %", "95 %", "count"):
        table.add_column(name, justify="right", no_wrap=True)
    for key, values in numbers["metrics"].items():
        table.add_row(key, *map(_short, values.values()))
    terminal().print(table)


def _short(value: float | None) -> str:
    """At most eight characters; quantiles of a random draw deserve no more."""
    if value is None:
        return "-"
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"
