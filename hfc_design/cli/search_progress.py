"""Progress of a search on stderr, and the folder of a new run."""

import time
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Self

from hfc_design.core.console import ProgressBar
from hfc_design.core.records import writing
from hfc_design.files.scenario import Scenario
from hfc_design.runs.champion import Lap
from hfc_design.search.loop import Search
from hfc_design.search.polish import Polished


def free_folder(name: str) -> Path:
    """Create and return the folder runs/NAME-N of a new run; RunError: it cannot be created."""
    for folder in (Path("runs") / f"{name}-{number}" for number in count(1)):
        with writing(folder), suppress(FileExistsError):
            folder.mkdir(parents=True)
            break
    return folder


#: Text on the step after the last generation of a search.
JUDGING = "judging the results"


class Watch(ProgressBar):
    """Progress of a search for a scenario: best and median merit, speed."""

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
        self.say("compiling and generating the first individuals")
        return super().__enter__()

    def generation(self, search: Search) -> None:
        """Show one finished generation."""
        now = time.monotonic()
        done, history = search.generation, search.history
        self._diverged = int(history.diverged.sum())
        if self._first is None:
            self._first = (done, now)  # the time of the first one includes the compilation
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
            if left >= 1.0:  # it is 0 right after the compilation, when it is not known yet
                line += f"  {left:.0f} s left"
            self.say(f"generation {done}/{self.total}  {self._title}: {line}")
            self._said = now

    def lap(self, lap: Lap) -> None:
        """Print the reason for another search."""
        assert lap.use is not None
        self.say(f"{lap.use.answer}\nnew search: {lap.number + 2} of at most {self._laps}")
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
        """Return a line on the time of the whole run, and on how many individuals diverged."""
        seconds = time.monotonic() - self._begun
        polish = ", polish" if self._polish else ""
        return (
            f"{seconds:.1f} s of search{polish} and judging; {self._diverged} individuals diverged"
        )
