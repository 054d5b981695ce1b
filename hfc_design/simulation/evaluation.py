"""What a design does on a scenario: its merit, its metrics, the whole motion of every axis.

And what tables say of several of them.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.controller import Signals
from hfc_design.core.arguments import wanted
from hfc_design.core.numbers import Floats, Json, Memory, Parameters
from hfc_design.core.shown import line, table
from hfc_design.files.doubts import doubts
from hfc_design.files.scenario import Scenario
from hfc_design.motion.contour import Contour
from hfc_design.motion.samples import AxisSamples
from hfc_design.objectives.judge import Judge
from hfc_design.simulation.closed_loop import Recorded, axis_signals
from hfc_design.simulation.divergence import Divergence
from hfc_design.simulation.repeats import TOLD, Each, ends_told, range_told
from plants import Drive, Machine, in_a_name

#: What ``Evaluation`` is called where something else is given.
EVALUATED = "evaluation; evaluate(design, scenario) makes one"


class AxisMotion(NamedTuple):
    """What one axis of the machine was to do, and did; in the units of its drive."""

    name: str
    drive: Drive
    parameters: Parameters
    happens: AxisSamples
    motion: Recorded  # leaves (steps,)

    @property
    def reference(self) -> Floats:
        """(steps,) what the control was told."""
        return np.asarray(self.happens.reference)

    @property
    def load(self) -> Floats:
        """(steps,)."""
        return np.asarray(self.happens.loads[0])

    @property
    def velocity(self) -> Floats:
        """(steps,) of the position."""
        return np.asarray(getattr(self.motion.state, self.drive.velocity))

    @property
    def readings(self) -> dict[str, Floats]:
        """The drive's signals, each (steps,)."""
        fixed = self.drive.coefficients(self.parameters)
        return _arrays(self.drive.signals(fixed, self.motion.state))

    def told(self) -> dict[str, Floats]:
        """What the axis told the control by its own sensors, signal -> (steps,)."""
        fixed = self.drive.coefficients(self.parameters)
        seen = self.drive.measured(fixed, self.motion.state)
        return _arrays(axis_signals(self.drive, fixed, seen, self.happens))


def _arrays(signals: Signals) -> dict[str, Floats]:
    return {name: np.asarray(value) for name, value in signals.items()}


class Evaluation(NamedTuple):
    """What a design does on a scenario."""

    fitness: float  # -inf where it diverged
    merit: float  # what it is ranked by, see ``Scenario.judge``; -inf where it diverged
    diverged: bool
    machine: Machine
    metrics: dict[str, float | None]
    time: Floats  # (steps,) [s]
    axes: tuple[AxisMotion, ...]
    contour: Contour | None  # of an X-Y machine on a path
    substeps: int = 1  # with which it was simulated; more than the scenario's where that diverged
    divergence: Divergence | None = None  # when and why it diverged
    #: Of a scenario of several motions the evaluation of each, by its name; what is above this is
    #: that of the first one then, but for fitness, merit and metrics, which are of all.
    motions: Mapping[str, "Evaluation"] = MappingProxyType({})
    #: "fitness" and "merit" -> those of repeats; nothing where none were simulated.
    repeats: Each = MappingProxyType({})
    memory: Memory = None  # what the controller remembers in the end

    def __repr__(self) -> str:
        return line("Evaluation", self._told())

    def _repr_html_(self) -> str:
        return table("Evaluation", self._told() | self.metrics)

    def _told(self) -> dict[str, object]:
        axes, steps = ", ".join(axis.name for axis in self.axes), len(self.time)
        told = {"fitness": self.fitness, "merit": self.merit, "diverged": self.diverged}
        more = {"motions": ", ".join(self.motions)} if self.motions else {}
        return told | {"axes": axes, "samples": steps} | more

    @property
    def chaotic(self) -> bool:
        """Whether a millionth of the command moves fitness or merit by more than one percent."""
        return bool(self.ranges)

    @property
    def ranges(self) -> dict[str, Json]:
        """``Repeats.numbers`` of the fitness or merit that is chaotic, by its key."""
        if self.diverged:
            return {}
        return {key: one.numbers() for key, one in self.repeats.items() if one.chaotic}

    @property
    def worth(self) -> float:
        """What it is ranked by: the merit, of a chaotic loop the lowest of the repeats."""
        known = self.repeats.get("merit")
        return self.merit if known is None or self.diverged else known.worth

    def score(self, judge: Judge) -> Json:
        """Fitness, merit and metrics as a file has them: None where there is no number.

        Of a chaotic loop the ranges as well.
        """
        fitness, merit = (None if self.diverged else x for x in (self.fitness, self.merit))
        found: Json = {"fitness": fitness, "merit": merit, "judged_by": judge.title}
        if ranges := self.ranges:
            found |= {"chaotic": True, "repeats": ranges}
        return found | self.metrics


def trajectory_csv(evaluation: Evaluation) -> str:
    """The motion as CSV with units in the header, one row a control sample.

    Raises:
        UserError: it is no evaluation.
    """
    wanted(evaluation, Evaluation, EVALUATED)
    columns = {"time_s": evaluation.time}
    several = len(evaluation.axes) > 1
    for axis in evaluation.axes:
        own = _columns(axis, every=not several)
        columns |= {(f"{axis.name}_" if several else "") + key: x for key, x in own.items()}
    if evaluation.contour is not None:
        columns[f"contour_error_{in_a_name(evaluation.contour.unit)}"] = evaluation.contour.error
    lines = [",".join(columns)]
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    lines += [",".join(map(repr, row)) for row in rows]
    return "\n".join(lines) + "\n"


def _columns(axis: AxisMotion, every: bool) -> dict[str, Floats]:
    """One axis; ``every`` adds what a table of several has no room for."""
    drive, state = axis.drive, axis.motion.state
    unit = {signal: in_a_name(unit) for signal, unit in drive.units.items()}
    columns = {
        f"reference_{unit['error']}": axis.reference,
        f"{drive.position}_{unit['error']}": getattr(state, drive.position),
        f"error_{unit['error']}": axis.motion.error,
        f"{drive.velocity}_{unit['error_rate']}": getattr(state, drive.velocity),
    }
    if "deflection" in axis.readings and every:
        columns[f"deflection_{unit['deflection']}"] = axis.readings["deflection"]
    columns[f"{drive.command_name}_{unit['command']}"] = axis.motion.command
    if every:
        columns[f"{drive.load_name}_{unit['load']}"] = axis.load
    return columns


def score_rows(judge: Judge, found: Sequence[Evaluation], form: str, none: str) -> list[list[str]]:
    """Fitness, merit and metrics, a row each; a column for each evaluation.

    A metric is written in a ``form``, as ``none`` where it has no value; a loop whose error comes
    back again and again settles never.
    """
    rows = []
    for key, title in judge.titles.items():
        rows.append([title, *(_score(x, key) for x in found)])
    for key in found[0].metrics:
        rows.append([key, *(_metric(item, key, form, none) for item in found)])
    return rows


def _metric(found: Evaluation, key: str, form: str, none: str) -> str:
    value = found.metrics[key]
    if value is not None:
        return f"{value:{form}}"
    return "never" if key.endswith("settling_time_s") and not found.diverged else none


def _score(found: Evaluation, key: str) -> str:
    """The fitness or the merit, as a range where it is chaotic."""
    if found.diverged:
        return "diverged"
    many = found.ranges.get(key)
    return range_told(many) if many else f"{getattr(found, key):.4f}"


def motion_rows(found: Sequence[Evaluation], form: str, none: str) -> list[list[str]]:
    """Of several motions the first metric, the error: a row each; a column for each evaluation."""
    rows = []
    for name, one in found[0].motions.items():
        key = next(iter(one.metrics))
        values = [item.motions[name].metrics[key] for item in found]
        cells = [none if value is None else f"{value:{form}}" for value in values]
        rows.append([f"{name} {key}", *cells])
    return rows


def notes(scenario: Scenario, rows: Mapping[str, Evaluation]) -> list[str]:
    """What has to be told beside the numbers of some designs, a line each."""
    found, own = doubts(scenario), scenario.simulation.substeps
    for name, one in rows.items():
        if one.divergence:
            tried = f", with {one.substeps} substeps too" if one.substeps > own else ""
            found.append(f"{name} diverges: {one.divergence}{tried}")
        elif one.substeps > own:
            found.append(
                f"{name} is simulated with {one.substeps} substeps, it diverges with {own}"
            )
        if one.chaotic:
            told = (key for key in scenario.judge().titles if key in one.ranges)
            ranges = [f"{key} ranges from {ends_told(one.ranges[key])}" for key in told]
            found.append(
                f"{name} is chaotic: {TOLD}, {', '.join(ranges)}; all else is of the unchanged run"
            )
    return found
