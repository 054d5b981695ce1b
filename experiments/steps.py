"""What finer steps of the integration, and another window, change of the figures of a page.

python -m experiments.steps runs/huang-shy      # after its hfc batch, before its page; some minutes

Every run of a batch is simulated again in 4 and 16 times its substeps. A figure that this moves by
more than ``CONVERGED`` stands on the page as a range. The path error leaves out a time after each
reversal, of which no paper says how long it is: beside it stands what 0.8 to 2 s make of it.
"""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import click
import numpy as np

from hfc_design.batch.results import runs_below
from hfc_design.cli.usage import Plain
from hfc_design.core.checkpoint import write_whole
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.motion.reversals import GLITCH_TIME, undisturbed
from hfc_design.motion.samples import MAX_SUBSTEPS
from hfc_design.runs.run import finished_run
from hfc_design.simulation.evaluating import Evaluation, evaluate

FINER = (1, 4, 16)
WINDOWS = (0.8, GLITCH_TIME, 1.5, 2.0)  # [s]
#: Behind the name of the path error with each of these.
WINDOWED = f" with {min(WINDOWS):g} to {max(WINDOWS):g} s left out"
#: A figure that changes by no more than this share of itself counts as converged.
CONVERGED = 0.01
FILE = "steps.json"
#: Metric -> its value, the smallest and the largest that it may have as well.
Ranges = dict[str, list[float]]


class Ranged(float):
    """A metric, printed as the range that steps give it where that is wide."""

    low: float
    high: float

    @classmethod
    def of(cls, value: float, low: float, high: float) -> "Ranged":
        """A value and what it may be as well."""
        found = cls(value)
        found.low, found.high = low, high
        return found

    @classmethod
    def among(cls, values: Sequence[float]) -> "Ranged":
        """The first of some values, and their ends."""
        return cls.of(values[0], min(values), max(values))

    def over(self, other: "Ranged") -> "Ranged":
        """The ratio; its range holds whatever either of both is."""
        sides = [a / b for a in (self.low, self.high) for b in (other.low, other.high)]
        return Ranged.of(self / other, min(sides), max(sides))

    def with_also(self, value: float) -> "Ranged":
        """The same where it may be another ``value`` too."""
        return Ranged.of(self, min(self.low, value), max(self.high, value))

    @property
    def wide(self) -> bool:
        """Whether it is a range."""
        return self.high - self.low > CONVERGED * max(abs(self.low), abs(self.high))

    def __format__(self, form: str) -> str:
        told = (self.low, self.high) if self.wide else (float(self),)
        return " to ".join(dict.fromkeys(format(value, form) for value in told))


def ranges(design: Design, scenario: Scenario) -> Ranges:
    """Every metric of a design as it is, its smallest and its largest over steps and windows."""
    found: Ranges = {}
    for times in FINER:
        for key, value in _metrics(design, finer(scenario, times)):
            own, low, high = found.get(key, [value] * 3)
            found[key] = [own, min(low, value), max(high, value)]
    return found


def figures(design: Design, scenario: Scenario) -> dict[str, Ranged]:
    """Every metric of a design with its range."""
    return {key: Ranged.of(*own) for key, own in ranges(design, scenario).items()}


def finer(scenario: Scenario, times: int) -> Scenario:
    """The scenario with so many times its substeps, as far as there may be."""
    steps = min(times * scenario.simulation.substeps, MAX_SUBSTEPS)
    simulation = scenario.simulation.model_copy(update={"substeps": steps})
    return scenario.model_copy(update={"simulation": simulation})


def _metrics(design: Design, scenario: Scenario) -> Iterator[tuple[str, float]]:
    """Fitness, merit and metrics of a motion; several where a last bit or a window decides."""
    found = evaluate(design, scenario)
    for key, value in {"fitness": found.fitness, "merit": found.merit, **found.metrics}.items():
        if value is not None and np.isfinite(value):
            yield key, float(value)
        if key in found.ranges:
            yield from ((key, float(x)) for x in found.repeats[key].values)
        if key.startswith("path_error_") and value is not None:
            yield from ((key + WINDOWED, error) for error in _path_errors(found))


def _path_errors(found: Evaluation) -> Iterator[float]:
    """With each of the windows."""
    assert found.contour is not None  # it has the metric
    for window in WINDOWS:
        quiet = undisturbed(found.time, found.contour.samples.velocity, window)
        yield float(np.abs(found.contour.error[quiet]).max(initial=0.0))


@click.command(cls=Plain)
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
def main(folders: tuple[Path, ...]) -> None:
    """Write the ranges of every finished run of the batches in FOLDERS beside them."""
    for folder in folders:
        runs = [run for run in runs_below(folder) if run.state == "finished"]
        found: dict[str, Ranges] = {}
        for run in runs:
            scenario, result = finished_run(folder / run.path)
            found[str(run.path)] = own = ranges(result.design, scenario)
            wide = [key for key, figure in own.items() if Ranged.of(*figure).wide]
            click.echo(f"{folder / run.path}: {len(wide)} of {len(own)} figures are ranges")
        write_whole(folder / FILE, json.dumps(found, indent=1).encode())


if __name__ == "__main__":
    main()
