"""What ``hfc design`` and ``hfc score`` show: progress on stderr, tables on stdout."""

import json
import time
from contextlib import suppress
from itertools import count
from pathlib import Path
from textwrap import fill
from typing import Any, Self

from rich.table import Table

from hfc_design.cli.usable_table import score_spread, show_usable
from hfc_design.core.console import ProgressBar, busy, room, show_whole
from hfc_design.core.numbers import Json
from hfc_design.core.records import writing
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.runs.champion import Lap
from hfc_design.search.loop import Search
from hfc_design.search.polish import Polished
from hfc_design.simulation.evaluating import Evaluation, evaluate, motion_rows, notes, score_rows
from hfc_design.simulation.in_use import Usable
from hfc_design.simulation.monte_carlo import Robustness, check_draw
from hfc_design.simulation.usable import SPREAD, usable


def free_folder(name: str) -> Path:
    """Make the folder of a new run of a scenario; RunError: it cannot be made."""
    for folder in (Path("runs") / f"{name}-{number}" for number in count(1)):
        with writing(folder), suppress(FileExistsError):
            folder.mkdir(parents=True)
            break
    return folder


#: What is done when a search has ended.
JUDGING = "judging what was found"


class Watch(ProgressBar):
    """The search of a scenario: its best and median, how fast it is."""

    def __init__(self, scenario: Scenario):
        super().__init__("compiling", scenario.search.generations)
        self._steps = scenario.search.population * scenario.simulation.steps
        self._polish, self._laps = scenario.run.polish, scenario.run.extend
        self._title = scenario.judge().title
        self._begun = self._said = time.monotonic()
        self._first: tuple[int, float] | None = None
        self._diverged = 0

    def __enter__(self) -> Self:
        if self.console.is_terminal:
            self.console.print(self._title, markup=False)
        self.say("compiling, and looking for first individuals")
        return super().__enter__()

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
            f"diverged {history.diverged[-1]}  structures {history.structures[-1]}"
        )
        if done > begun:
            line += f"  {rate:.2g} individual-steps/s"
        ended = done == self.total
        self.show(description=JUDGING if ended else "generation", completed=done, line=line)
        if ended:
            self.say(f"generation {done}/{self.total}  {self._title}: {line}\n{JUDGING}")
        elif now - self._said > 5.0:
            left = (self.total - done) * (now - since) / max(done - begun, 1)
            if left >= 1.0:  # less is not known, right after the compilation
                line += f"  {left:.0f} s left"
            self.say(f"generation {done}/{self.total}  {self._title}: {line}")
            self._said = now

    def lap(self, lap: Lap) -> None:
        """Say why there is another search."""
        assert lap.use is not None
        self.say(f"{lap.use.answer}\nanother start: {lap.number + 2} of {self._laps} at most")
        self._first = None

    def polished(self, done: Polished) -> None:
        """Show one finished step of the polish."""
        total, now = self._polish, time.monotonic()
        line = f"from {done.first[0, 0]:.5g} to {done.worth[0, 0]:.5g}"
        self.show(description="polish", completed=done.step, total=total, line=line)
        if done.step == total or now - self._said > 5.0:
            self.say(f"polish {done.step}/{total}  {self._title}: {line}")
            self._said = now

    def summary(self) -> str:
        """Time and divergence of the whole run, until its design is judged."""
        seconds = time.monotonic() - self._begun
        polish = ", polish" if self._polish else ""
        return (
            f"{seconds:.1f} s of search{polish} and judging; {self._diverged} individuals diverged"
        )


def show_table(scenario: Scenario, rows: dict[str, Evaluation], caption: str = "") -> None:
    """Fitness, merit and metrics of some designs side by side, one column a design."""
    table = Table(caption=caption or None, caption_justify="left")
    table.add_column("metric", no_wrap=True)
    for name in rows:
        head = fill(name, 12, break_long_words=False, break_on_hyphens=False)
        table.add_column(head, justify="right")
    found = [*rows.values()]
    titles = len(scenario.judge().titles)
    shown = score_rows(scenario.judge(), found, ".5g", "-")
    if scenario.motions:  # of each the first one says most; the others are in --json and the report
        shown = shown[:titles] + motion_rows(found, ".4g", "-")
    for name, *values in shown:
        table.add_row(name.replace(" / ", "\n/ "), *values)
    show_whole(table)
    for note in notes(scenario, rows):
        print(fill(note, room()))


def score_one(
    design: Design,
    scenario: Scenario,
    spread: float | None,
    as_json: bool,
    plot: Path | None = None,
    **given: Any,
) -> None:
    """``hfc score`` on one scenario: can it be used, where tolerances are told, then how good.

    Raises:
        UserError: a value is not allowed, or design and scenario do not fit.
    """
    found: Usable | Robustness | None = None
    if usable := bool(scenario.robust or (scenario.motions and spread is not None)):
        found = score_usable(design, scenario, spread, as_json, **given)
    elif spread is not None:
        found = score_spread(design, scenario, spread, as_json, **given)
    if found is not None and plot is not None:
        from hfc_design.pictures.files import save
        from hfc_design.report.batch_plots import distributions

        save(distributions(found, f"{design.name} on {scenario.name}"), plot)
        if not as_json:
            print(plot)
    if found is not None and (as_json or not usable):
        return
    evaluation = evaluate(design, scenario)
    if not as_json:
        if not (scenario.robust or spread is not None):
            print(f"scenario {scenario.name}")
        show_table(scenario, {design.name: evaluation})
        return
    print(json.dumps(_numbers(design, scenario, evaluation)))


def _numbers(design: Design, scenario: Scenario, found: Evaluation) -> Json:
    """What there is to know before a number is believed, and the numbers."""
    lost = found.divergence and found.divergence._asdict()
    told = {"design": design.name, "scenario": scenario.name, "diverged": found.diverged}
    told |= {"chaotic": found.chaotic, "substeps": found.substeps, "divergence": lost}
    return told | found.score(scenario.judge())


def score_usable(
    design: Design,
    scenario: Scenario,
    spread: float | None,
    as_json: bool,
    samples: int | None = None,
    seed: int | None = None,
) -> Usable:
    """Whether a design can be used in every motion of a scenario.

    Raises:
        UserError: a value is not allowed, or design and scenario do not fit.
    """
    own = SPREAD if spread is None else spread
    check_draw(own, 1 if samples is None else samples, 0 if seed is None else seed)
    with busy("on machines that no search has seen"):
        found = usable(design, scenario, spread, samples, seed)
    if as_json:
        numbers = _numbers(design, scenario, evaluate(design, scenario))
        print(json.dumps(numbers | {"can_i_use_it": found.numbers()}))
    else:
        print(f"{design.name} on {scenario.name}")
        show_usable(found.numbers())
    return found
