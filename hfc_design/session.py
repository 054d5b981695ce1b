"""What the commands say to a person: progress, tables, lists."""

import json
import sys
import time
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from hfc_design import controllers, evaluate, rulebase, scenarios
from hfc_design import design as designs
from hfc_design.evaluate import Evaluation
from hfc_design.export import FORMATS
from hfc_design.laws.law import LAWS
from hfc_design.machine_settings import ALL_PLANTS
from hfc_design.records import RunError, UserError
from hfc_design.rulebase import Design
from hfc_design.scenarios import Scenario
from hfc_design.search.loop import Search

#: Plant -> designs shown beside every result, and their names in the table.
BASELINES = {
    "c-axis": {
        "lin-lee-1999-table-1": "LL Table I",
        "lin-lee-1999-table-2": "LL Table II",
        "pd-only": "PD only",
    },
    "feed-drive": {
        "jee-koren-2004-aflc": "JK04 AFLC",
        "jee-koren-2004-flc": "JK04 FLC",
        "jee-koren-2004-pid": "JK04 PID",
    },
}


def design(
    name: str | None, out: Path | None, changes: list[str], resume: bool, quiet: bool
) -> None:
    """``hfc design``: start or resume a run, report it, print the table.

    Raises:
        UserError: the scenario, an option or the folder cannot be used.
        RunError: the run failed or was interrupted.
    """
    if resume:
        if out is None or name is not None or changes:
            raise UserError("--resume needs --out DIR and nothing else: config.toml says the rest")
        scenario, folder = designs.opened_run(out), out
    else:
        scenario = scenarios.load_scenario(name or "c-axis-ramp", changes)
        folder = out or _free_folder(scenario.name)
        scenario = designs.new_run(scenario, folder)
    watch = Quiet() if quiet else Watch(scenario)
    try:
        with watch:
            result = designs.run(scenario, folder, watch.generation)
    except KeyboardInterrupt:
        raise RunError(f"interrupted; continue with: hfc design --resume --out {folder}") from None
    rivals = write_page(scenario, result, folder)
    baselines = BASELINES.get(scenario.plant.name, {})
    beside = {baselines[name]: rival for name, rival in rivals.items()}
    show_table(scenario, {"this design": result.evaluation, **beside}, watch.summary())
    Console().print(f"run folder {folder}\nreport     {folder / 'report.html'}", soft_wrap=True)


def write_page(scenario: Scenario, result: designs.Result, folder: Path) -> dict[str, Evaluation]:
    """Write the page of a run beside the published designs; returns what these do.

    Raises:
        RunError: the folder cannot be written.
    """
    from hfc_design.report import write_report

    baselines = BASELINES.get(scenario.plant.name, {})
    rivals = {name: rival for name in baselines if (rival := _rival(name, scenario))}
    write_report(scenario, result, rivals, folder)
    return rivals


class Quiet:
    """Progress that says nothing."""

    def __enter__(self) -> "Quiet":
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def generation(self, search: Search) -> None:
        """Nothing."""

    def summary(self) -> str:
        """Nothing."""
        return ""


class Watch(Quiet):
    """Live progress on a terminal, a line now and then elsewhere; both on stderr."""

    def __init__(self, scenario: Scenario):
        self._console = Console(stderr=True)
        self._total = scenario.search.generations
        self._steps = scenario.search.population * scenario.simulation.steps
        self._begun = self._said = time.monotonic()
        self._first: tuple[int, float] | None = None
        self._diverged = 0
        self._bar = _bar(self._console)
        self._task = self._bar.add_task("compiling", total=self._total, line="")

    def __enter__(self) -> "Watch":
        self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def generation(self, search: Search) -> None:
        """Show one finished generation."""
        now = time.monotonic()
        done, history = search.generation, search.history
        self._diverged = int(history.diverged.sum())
        if self._first is None:
            self._first = (done, now)  # the first one includes the compilation
        begun, since = self._first
        rate = (done - begun) * self._steps / (now - since) if now > since else 0.0
        line = (
            f"best {history.best[-1]:.5g}  median {history.median[-1]:.5g}  "
            f"diverged {history.diverged[-1]}  structures {history.structures[-1]}  "
            f"{rate:.2g} individual-steps/s"
        )
        self._bar.update(self._task, description="generation", completed=done, line=line)
        if not self._console.is_terminal and (now - self._said > 5.0 or done == self._total):
            left = (self._total - done) * (now - since) / max(done - begun, 1)
            print(f"generation {done}/{self._total}  {line}  {left:.0f} s left", file=sys.stderr)
            self._said = now

    def summary(self) -> str:
        """Time and divergence of the whole run."""
        seconds = time.monotonic() - self._begun
        return f"{seconds:.1f} s; {self._diverged} individuals diverged and scored 0"


#: What the fitness of a kind is called in a table.
FITNESSES = {"lin-lee": "fitness, LL eq. 5", "contour": "fitness [1/BLU]"}


def show_table(scenario: Scenario, rows: dict[str, Evaluation], caption: str = "") -> None:
    """Fitness and metrics of some designs side by side, one column a design."""
    table = Table(caption=caption or None, caption_justify="left")
    table.add_column("metric", no_wrap=True)
    for name in rows:
        table.add_column(name, justify="right", overflow="fold")
    cells = [f"{row.fitness:.4f}" if not row.diverged else "diverged" for row in rows.values()]
    kind = scenario.fitness.kind
    table.add_row(FITNESSES.get(kind, f"fitness, {kind}"), *cells)
    first = next(iter(rows.values()))
    for key in first.metrics:
        found = (row.metrics[key] for row in rows.values())
        table.add_row(key, *("-" if value is None else f"{value:.5g}" for value in found))
    Console().print(table)


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
    from hfc_design.monte_carlo import robustness

    console = Console(stderr=True)
    bar = _bar(console)
    task = bar.add_task("compiling", total=samples + 1, line="machines")

    def progress(done: int, total: int) -> None:
        bar.update(task, description="simulating", completed=done, total=total)

    begun = time.monotonic()
    with bar:
        found = robustness(design, scenario, spread, samples, seed, progress)
    print(f"{samples} machines in {time.monotonic() - begun:.1f} s", file=sys.stderr)
    numbers = {"design": design.name, "scenario": scenario.name, **found.numbers()}
    if as_json:
        print(json.dumps(numbers))
    else:
        _show_spread(numbers)
    if plot is not None:
        from hfc_design.pictures.plots import save
        from hfc_design.pictures.spread_plots import distributions

        save(distributions(found, f"{design.name} on {scenario.name}"), plot)


def _show_spread(numbers: dict[str, Any]) -> None:
    table = Table(
        title=f"{numbers['design']} on {numbers['scenario']}, "
        f"parameters +-{100 * numbers['spread']:g} %",
        title_justify="left",
        title_style="",
        caption=f"{100 * numbers['stable_share']:.4g} % of {numbers['samples']} machines are "
        f"stable, the nominal one {'too' if numbers['nominal_stable'] else 'is not'}\n"
        "quantiles of the stable ones that have the metric\n"
        f"impossible machines drawn again: {numbers['refused_draws']}\n"
        f"simulated again with shorter steps: {numbers['refined']}",
        caption_justify="left",
        box=SIMPLE_HEAD,
        show_edge=False,
        padding=0,  # so that eight columns fit into a terminal of 80
    )
    table.add_column("metric", no_wrap=True)
    for name in ("nominal", "5 %", "25 %", "50 %", "75 %", "95 %", "count"):
        table.add_column(name, justify="right", no_wrap=True)
    for key, values in numbers["metrics"].items():
        table.add_row(key, *map(_short, values.values()))
    Console().print(table)


def _short(value: float | None) -> str:
    """At most eight characters; quantiles of a random draw deserve no more."""
    if value is None:
        return "-"
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"


def _bar(console: Console) -> Progress:
    """A progress bar on a terminal, else nothing; a task's ``line`` stands behind its counts."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        TextColumn("{task.completed:.0f}/{task.total:.0f} {task.fields[line]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=console,
        disable=not console.is_terminal,
    )


def show_list(what: str) -> None:
    """Names of what is built in, with a line about each."""
    if what == "scenarios":
        names = scenarios.builtin_names()
        lines = {name: scenarios.load_scenario(name).description for name in names}
    elif what == "designs":
        names = rulebase.builtin_designs()
        lines = {name: str(evaluate.load_design(name).provenance["source"]) for name in names}
    elif what == "plants":
        plants = {name: ALL_PLANTS.get(name) for name in ALL_PLANTS.names()}
        lines = {name: ", ".join(plant.parameters._fields) for name, plant in plants.items()}
    elif what == "controllers":
        lines = dict.fromkeys(LAWS.names(), "an own law") | controllers.KINDS
    else:
        lines = {name: text for name, (text, _) in FORMATS.items()}
    table = Table(box=None, show_header=False)
    for name, text in lines.items():
        table.add_row(name, text)
    Console().print(table)


def _rival(name: str, scenario: Scenario) -> Evaluation | None:
    """A published design on this scenario; None where it does not fit the plant or sampling."""
    try:
        return evaluate.evaluate(evaluate.load_design(name), scenario)
    except UserError:
        return None


def _free_folder(name: str) -> Path:
    number = 1
    while (folder := Path("runs") / f"{name}-{number}").exists():
        number += 1
    return folder
