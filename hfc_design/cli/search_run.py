"""The run of ``hfc design``: its progress, and its table beside the published designs."""

import sys
import time
from contextlib import nullcontext
from pathlib import Path

from hfc_design.cli.terminal import progress_bar, show_table
from hfc_design.core.console import terminal
from hfc_design.core.records import RunError, UserError
from hfc_design.files.scenario import Scenario, load_scenario
from hfc_design.report import page
from hfc_design.runs import run as designs
from hfc_design.search.loop import Search


def design(
    name: str | None, changes: list[str], resume: bool, out: Path | None, quiet: bool
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
        scenario = load_scenario(name or "c-axis-ramp", changes)
        folder = out or _free_folder(scenario.name)
        scenario = designs.new_run(scenario, folder)
    watch = None if quiet else Watch(scenario)
    try:
        with watch or nullcontext():
            told = (watch.generation,) if watch else ()
            result = designs.run(scenario, folder, *told)
    except KeyboardInterrupt:
        raise RunError(f"interrupted; continue with: hfc design --resume --out {folder}") from None
    others = page.write_page(scenario, result, folder)
    baselines = page.BASELINES.get(scenario.plant.name, {})
    beside = {baselines[name]: rival for name, rival in others.items()}
    show_table(
        scenario, {"this design": result.evaluation, **beside}, watch.summary() if watch else ""
    )
    terminal().print(f"run folder {folder}\nreport     {folder / 'report.html'}", soft_wrap=True)


class Watch:
    """Live progress on a terminal, a line now and then elsewhere; both on stderr."""

    def __init__(self, scenario: Scenario):
        self._console = terminal(stderr=True)
        self._total = scenario.search.generations
        self._steps = scenario.search.population * scenario.simulation.steps
        self._title = scenario.judge().title
        self._begun = self._said = time.monotonic()
        self._first: tuple[int, float] | None = None
        self._diverged = 0
        self._bar = progress_bar(self._console)
        self._task = self._bar.add_task("compiling", total=self._total, line="")

    def __enter__(self) -> "Watch":
        if self._console.is_terminal:
            self._console.print(self._title, markup=False)
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
            told = f"generation {done}/{self._total}  {self._title}: {line}  {left:.0f} s left"
            print(told, file=sys.stderr)
            self._said = now

    def summary(self) -> str:
        """Time and divergence of the whole run."""
        seconds = time.monotonic() - self._begun
        return f"{seconds:.1f} s; {self._diverged} individuals diverged"


def _free_folder(name: str) -> Path:
    number = 1
    while (folder := Path("runs") / f"{name}-{number}").exists():
        number += 1
    return folder
