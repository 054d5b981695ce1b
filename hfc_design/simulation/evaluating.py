"""Evaluation of a design on a scenario in float64: merit, metrics, the motions of all axes.

Functions that make tables of several evaluations come last.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import product, starmap
from operator import attrgetter
from types import MappingProxyType
from typing import NamedTuple

import jax
import numpy as np

from hfc_design.controllers.controller import Signals, within_rate
from hfc_design.core.arguments import check_type
from hfc_design.core.numbers import Floats, Gains, Integers, Json, Memory, Parameters
from hfc_design.core.records import UserError
from hfc_design.core.tables import MISSING, Table, line, table
from hfc_design.files.design import AnyDesign, Design, learned
from hfc_design.files.loop_setup import controller_of, load_design, machine, with_converter
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.plausibility import plausibility_warnings
from hfc_design.files.scenario import Scenario
from hfc_design.motion.contour import Contour, contour, during
from hfc_design.motion.phases import settled_samples
from hfc_design.motion.program import Program
from hfc_design.motion.samples import AxisSamples, Samples
from hfc_design.motion.tool_path import program_errors
from hfc_design.motion.trajectories import Circle
from hfc_design.objectives.judge import Judge, Judged
from hfc_design.objectives.metric import ALONE, PLANE, PROGRAM, AxisRecord, MotionRecord
from hfc_design.objectives.tables import Column, columns, length_unit, values
from hfc_design.simulation import memory, population
from hfc_design.simulation.closed_loop import Loop, Recorded, axis_signals, closed_loop
from hfc_design.simulation.divergence import Divergence, divergence_of, refined
from hfc_design.simulation.population import Machines
from hfc_design.simulation.repeats import (
    TOLD,
    Each,
    averaged,
    ends_text,
    range_text,
    repeats_of,
    scaled_command,
    together,
)
from hfc_design.simulation.stepping import Motions
from plants import Drive, Machine, in_a_name
from plants.around import plain

#: Text that describes an ``Evaluation`` in the message about a wrong argument.
EVALUATED = "an evaluation, as evaluate(design, scenario) returns it"


class AxisMotion(NamedTuple):
    """Reference and motion of one axis of the machine, in the units of its drive."""

    name: str
    drive: Drive
    parameters: Parameters
    happens: AxisSamples
    motion: Recorded  # leaves (steps,)

    @property
    def reference(self) -> Floats:
        """(steps,) reference, as given to the control."""
        return np.asarray(self.happens.reference)

    @property
    def load(self) -> Floats:
        """(steps,) load at the start of each sample."""
        return np.asarray(self.happens.loads[0])

    @property
    def velocity(self) -> Floats:
        """(steps,) derivative of the position."""
        return np.asarray(getattr(self.motion.state, self.drive.velocity))

    @property
    def readings(self) -> dict[str, Floats]:
        """Exact signals of the drive, before its sensors, (steps,) each."""
        fixed = self.drive.coefficients(self.parameters)
        return _arrays(self.drive.signals(fixed, self.motion.state))

    def sensed(self) -> dict[str, Floats]:
        """Return the signals of the axis as the drive's own sensors read them, (steps,) each."""
        fixed = self.drive.coefficients(self.parameters)
        seen = self.drive.measured(fixed, self.motion.state)
        return _arrays(axis_signals(self.drive, fixed, seen, self.happens))


def _arrays(signals: Signals) -> dict[str, Floats]:
    return {name: np.asarray(value) for name, value in signals.items()}


class Evaluation(NamedTuple):
    """Result of a design on a scenario."""

    fitness: float  # -inf where it diverged
    merit: float  # number by which designs are ranked, see ``Scenario.judge``; -inf if diverged
    diverged: bool
    machine: Machine
    metrics: dict[str, float | None]
    time: Floats  # (steps,) [s]
    axes: tuple[AxisMotion, ...]
    contour: Contour | None  # of an X-Y machine on a path
    substeps: int = 1  # of the simulation; more than in the scenario if it diverged with those
    divergence: Divergence | None = None  # when and why it diverged
    #: Evaluation of each motion by name, if there are several. Fitness, merit, metrics and repeats
    #: are then those of all motions, other fields those of the first, or first diverging, motion.
    motions: Mapping[str, "Evaluation"] = MappingProxyType({})
    #: "fitness" and "merit" -> values of all repeats; empty if none were simulated.
    repeats: Each = MappingProxyType({})
    memory: Memory = None  # final memory of the controller

    def __repr__(self) -> str:
        return line("Evaluation", self._summary())

    def _repr_html_(self) -> str:
        return table("Evaluation", self._summary() | self.metrics)

    def _summary(self) -> dict[str, object]:
        axes, steps = ", ".join(axis.name for axis in self.axes), len(self.time)
        summary = {"fitness": self.fitness, "merit": self.merit, "diverged": self.diverged}
        more = {"motions": ", ".join(self.motions)} if self.motions else {}
        return summary | {"axes": axes, "samples": steps} | more

    @property
    def chaotic(self) -> bool:
        """Whether a change of the command by a millionth changes fitness or merit by over 1 %."""
        return bool(self.ranges)

    @property
    def ranges(self) -> dict[str, Json]:
        """``Repeats.numbers`` of fitness and merit, each only if it is chaotic, by key."""
        if self.diverged:
            return {}
        return {key: one.numbers() for key, one in self.repeats.items() if one.chaotic}

    @property
    def worth(self) -> float:
        """Merit by which the design is ranked: of a chaotic loop the lowest of all repeats."""
        known = self.repeats.get("merit")
        return self.merit if known is None or self.diverged else known.worth

    def score(self, judge: Judge) -> Json:
        """Return fitness, merit and metrics as a file stores them; None where there is no number.

        For a chaotic loop the ranges of its repeats are included.
        """
        fitness, merit = (None if self.diverged else x for x in (self.fitness, self.merit))
        record: Json = {"fitness": fitness, "merit": merit, "judged_by": judge.title}
        if ranges := self.ranges:
            record |= {"chaotic": True, "repeats": ranges}
        return record | self.metrics


def trajectory_csv(evaluation: Evaluation) -> str:
    """Return the motion as CSV with units in the header, one row for each control sample.

    Raises:
        UserError: ``evaluation`` is not an ``Evaluation``.
    """
    check_type(evaluation, Evaluation, EVALUATED)
    columns = {"time_s": evaluation.time}
    several = len(evaluation.axes) > 1
    for axis in evaluation.axes:
        head, each = f"{axis.name}_" * several, _columns(axis, every=not several)
        columns |= {head + key: x for key, x in each.items()}
    if evaluation.contour is not None:
        columns[f"contour_error_{in_a_name(evaluation.contour.unit)}"] = evaluation.contour.error
    lines = [",".join(columns)]
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    lines += [",".join(map(repr, row)) for row in rows]
    return "\n".join(lines) + "\n"


def _columns(axis: AxisMotion, every: bool) -> dict[str, Floats]:
    """Return columns of one axis; ``every`` adds those that a table of several axes leaves out."""
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


def evaluate(design: AnyDesign, scenario: AnyScenario) -> Evaluation:
    """Simulate ``design`` on ``scenario``.

    The plant is the design's, with the parameters that the scenario sets. A motion that diverges is
    simulated again in finer steps, so that the loop is judged and not the integration. The
    ``repeats`` tell whether the loop is chaotic.

    Raises:
        UserError: design and scenario have different plants or sample times, or there is not
            enough memory.
    """
    design = load_design(design)
    scenario = with_converter(load_scenario(scenario), design)
    memory.check(scenario.name, memory.of_motion(scenario))
    machines = population.one_machine(machine(design, scenario).values())
    controller, gains = controller_of(design, scenario)

    def simulate(where: Scenario, chosen: Integers) -> Iterator[Evaluation]:
        motions = [where.each_motion()[k] for k in chosen]
        loop, many = scaled_command(closed_loop(where, controller), gains)
        for (evaluation,) in evaluations(motions, loop, machines, many):
            yield evaluation

    count = len(scenario.each_motion())
    results = refined(scenario, count, simulate, attrgetter("diverged"))
    if not scenario.motions:
        return results[0]
    names = (motion.name for motion in scenario.motions)
    return _together(scenario, dict(zip(names, results, strict=True)))


def learned_in(design: AnyDesign, scenario: AnyScenario, evaluation: Evaluation) -> Design:
    """Return the design with the values that it learned in the motion of ``evaluation``.

    Of several motions it is the first; the evaluations of others are in ``evaluation.motions``.

    Raises:
        UserError: the design does not learn, diverged, or ``evaluation`` is of another controller.
    """
    check_type(evaluation, Evaluation, EVALUATED)
    design, axes = load_design(design), evaluation.machine.axes
    begun = within_rate(design.commanding(axes).initial_memory(0.0))
    remembered: list[Memory] = [begun, within_rate(evaluation.memory)]
    expected, actual = map(str, map(jax.tree.structure, remembered))
    if actual != expected:
        why = "the evaluation must be of this controller (its remembered state differs)"
        raise UserError(f"design {design.name}: {why}")
    provenance = {"scenario": load_scenario(scenario).name, "samples": len(evaluation.time)}
    return learned(design, axes, evaluation.memory, provenance)


def evaluations(
    motions: Sequence[Scenario], loop: Loop, machines: Machines, gains: Gains
) -> Iterator[Iterator[Evaluation]]:
    """Yield for each motion the evaluations on all ``machines``, which are simulated together.

    On a single machine ``gains`` may be those of ``scaled_command``.
    """
    samples = [motion.samples() for motion in motions]
    trajectories = population.trajectories(loop, machines, samples, gains, machines.size)
    for motion, happens, moved in zip(motions, samples, trajectories, strict=True):
        yield _evaluations(motion, loop, machines, happens, *moved)


def _evaluations(
    scenario: Scenario,
    loop: Loop,
    machines: Machines,
    samples: Samples,
    judged: Judged,
    motions: Motions,
    memories: Memory,
) -> Iterator[Evaluation]:
    loop_machine, time = loop.machine, scenario.simulation.time
    many = len(judged.merit) > machines.size
    for k in range(machines.size):
        true = tuple(map(plain, machines.actual))
        parameters = jax.tree.map(lambda leaf, k=k: float(leaf[k]), true)
        moved = jax.tree.map(lambda leaf, k=k: leaf[:, k], motions)
        each = (loop_machine.axes, loop_machine.drives, parameters, samples.axes, moved)
        axes = tuple(starmap(AxisMotion, zip(*each, strict=True)))
        path = _contour(scenario, axes)
        parts = (slice(None), *(window.part(scenario.simulation) for window in scenario.windows))
        values = (value for part in parts for value in _metrics(scenario, axes, path, part))
        numbers = (x if x is not None and np.isfinite(x) else None for x in values)
        metric_values = dict(zip(meanings(scenario), numbers, strict=True))
        diverged = bool(judged.failed[k]) or not all(
            np.isfinite(part).all()
            for axis in axes
            for part in (axis.motion.error, axis.motion.command, axis.velocity)
        )
        scores = (float(judged.values[k, 0]), float(judged.merit[k]))
        fitness, merit = (-np.inf, -np.inf) if diverged else scores
        lost = divergence_of(time, _quantities(axes)) if diverged else None
        whole = Evaluation(fitness, merit, diverged, loop_machine, metric_values, time, axes, path)
        again = repeats_of(judged) if many else {}
        memory = jax.tree.map(lambda leaf, k=k: float(leaf[k]), memories)
        whole = whole._replace(substeps=loop.substeps, divergence=lost, repeats=again)
        yield whole._replace(memory=memory)


def _together(scenario: Scenario, motions: dict[str, Evaluation]) -> Evaluation:
    """Return one evaluation for several motions, with their weighted mean costs (1 / merit)."""
    first, *_ = motions.values()
    lost = [one for one in motions.values() if one.diverged]
    weights = np.array([motion.weight for motion in scenario.motions])

    def mean(merits: list[float]) -> float:
        return float(averaged(np.array([merits]), weights)[0])

    metrics: dict[str, float | None] = {}
    for name, one in motions.items():
        metrics |= {f"{_key(name)}_{key}": value for key, value in one.metrics.items()}
    each = [*motions.values()]
    return (lost[0] if lost else first)._replace(
        fitness=mean([one.fitness for one in each]),
        merit=mean([one.merit for one in each]),
        metrics=metrics,
        motions=motions,
        repeats=together([one.repeats for one in each], weights),
    )


def _quantities(axes: tuple[AxisMotion, ...]) -> dict[str, Floats]:
    """Return every state of the machine, then the commands, by name, (steps,) each."""
    several = len(axes) > 1
    heads = [f"{axis.name}: " if several else "" for axis in axes]
    pairs = [*zip(heads, axes, strict=True)]
    each = ((head, axis.motion.state._asdict()) for head, axis in pairs)
    states = {head + key: x for head, state in each for key, x in state.items()}
    return states | {f"{head}the command": axis.motion.command for head, axis in pairs}


def _metrics(
    scenario: Scenario, axes: tuple[AxisMotion, ...], path: Contour | None, part: slice
) -> list[float | None]:
    """Return all metrics of a part of the motion, in the order of ``_table``; None: no number."""
    time = scenario.simulation.time
    settled = settled_samples(time[part], scenario.fitness.settled_after_s)
    records = []
    for axis in axes:
        motion = jax.tree.map(lambda leaf: leaf[part], axis.motion)
        about = (axis.name, axis.drive, time[part], settled)
        commanded = (axis.reference[part], np.asarray(axis.happens.reference_rate)[part])
        seen = (motion.error, motion.error_rate, axis.velocity[part], motion.command)
        limit = scenario.limits.of(axis.name).command
        limits = axis.drive.largest_commands(axis.parameters, limit)
        records.append(AxisRecord(*about, *commanded, *seen, limits))
    whole = MotionRecord(tuple(records), None if path is None else during(path, time, part))
    return [*values(_table(scenario), whole).values()]


def _table(scenario: Scenario) -> dict[str, Column]:
    """Return the metrics of one motion by key, without those of windows."""
    path, table = scenario.path, ALONE
    if scenario.follows_path:
        table = PROGRAM if isinstance(path, Program) else PLANE
    turns = path.path.length if isinstance(path, Circle) and path.cycles >= 1.0 else ()
    return columns(scenario.machine, table, len(turns))


def table_of(scenario: Scenario) -> dict[str, Column]:
    """Return the metrics of an evaluation on a scenario by key, those of windows last."""
    if scenario.motions:
        names, alone = [one.name for one in scenario.motions], map(table_of, scenario.each_motion())
        pairs = zip(names, alone, strict=True)
        return {f"{_key(x)}_{key}": one.of(x) for x, y in pairs for key, one in y.items()}
    whole = _table(scenario)
    parts = product(scenario.windows, whole.items())
    inside = {f"{x.name}_{key}": one.of(x.name)._replace(rank=0) for x, (key, one) in parts}
    return whole | inside


def meanings(scenario: Scenario) -> dict[str, str]:
    """Return meaning and unit of every metric of an evaluation on a scenario, by key."""
    return {key: column.meaning for key, column in table_of(scenario).items()}


def _key(motion: str) -> str:
    """Return the name of a motion as the prefix of a metric's key."""
    return motion.replace("-", "_")


def _contour(scenario: Scenario, axes: tuple[AxisMotion, ...]) -> Contour | None:
    """Return the contour error of a machine; None if it follows no path."""
    path, time = scenario.path, scenario.simulation.time
    if path is None:
        return None
    positions = np.stack([getattr(axis.motion.state, axis.drive.position) for axis in axes])
    if isinstance(path, Program):
        return program_errors(path, time, positions, length_unit(scenario.machine))
    seen = None
    if any(axis.drive.off_its_position for axis in axes):
        seen = np.stack([getattr(axis.motion.state, axis.drive.seen[0]) for axis in axes])
    length = scenario.plant.each()[0].length
    assert length is not None  # the scenario has been checked
    return contour(path, time, positions, axes[0].drive.units["error"], length, seen)


def score_table(scenario: Scenario, evaluations: Mapping[str, Evaluation]) -> Table:
    """Return a table of fitness, merit and ``first_metrics``, with a column a design, and notes."""
    rows = score_rows(scenario.judge(), [*evaluations.values()])
    first = first_metrics(scenario, next(iter(evaluations.values())))
    shown = [row for key, row in rows.items() if key in first]
    return Table("", ["metric", *evaluations], shown, lines=notes(scenario, evaluations))


def first_metrics(scenario: Scenario, evaluation: Evaluation) -> Collection[str]:
    """Return titles of scores and keys of metrics to show: of several motions the first of each."""
    each = evaluation.motions.items()
    errors = (f"{_key(name)}_{next(iter(one.metrics))}" for name, one in each)
    metrics = errors if evaluation.motions else evaluation.metrics
    return [*scenario.judge().titles.values(), *metrics]


def score_rows(judge: Judge, results: Sequence[Evaluation]) -> dict[str, list[str]]:
    """Return rows of fitness, merit and metrics by title or key, with a cell for each evaluation.

    The settling time of a loop that does not settle is shown as "never".
    """
    scores = {title: [_score(x, key) for x in results] for key, title in judge.titles.items()}
    metrics = {key: [_metric(x, key) for x in results] for key in results[0].metrics}
    return {name: [name, *cells] for name, cells in (scores | metrics).items()}


def _metric(evaluation: Evaluation, key: str) -> str:
    value = evaluation.metrics[key]
    if value is not None:
        return f"{value:.5g}"
    return "never" if key.endswith("settling_time_s") and not evaluation.diverged else MISSING


def _score(evaluation: Evaluation, key: str) -> str:
    """Return the text of the fitness or the merit, which is a range if it is chaotic."""
    if evaluation.diverged:
        return "diverged"
    many = evaluation.ranges.get(key)
    return range_text(many) if many else f"{getattr(evaluation, key):.4f}"


def notes(scenario: Scenario, rows: Mapping[str, Evaluation]) -> list[str]:
    """Return remarks on the numbers of designs, a line each."""
    lines, substeps = plausibility_warnings(scenario), scenario.simulation.substeps
    for name, one in rows.items():
        if one.divergence:
            tried = f", also with {one.substeps} substeps" if one.substeps > substeps else ""
            lines.append(f"{name} diverges: {one.divergence}{tried}")
        elif one.substeps > substeps:
            finer = f"{name} is simulated with {one.substeps} substeps"
            lines.append(f"{finer}, it diverges with {substeps}")
        if one.chaotic:
            keys = (key for key in scenario.judge().titles if key in one.ranges)
            ranges = [f"{key} ranges from {ends_text(one.ranges[key])}" for key in keys]
            others = "all other figures are of the unchanged run"
            lines.append(f"{name} is chaotic: {TOLD}, {', '.join(ranges)}; {others}")
    return lines
