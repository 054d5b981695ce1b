"""A design on a scenario, simulated in float64 -> an ``Evaluation``."""

from collections.abc import Iterator, Sequence
from itertools import chain, starmap

import jax
import numpy as np

from hfc_design.controllers.controller import within_rate
from hfc_design.core.arguments import wanted
from hfc_design.core.numbers import Floats, Gains, Memory
from hfc_design.core.records import UserError
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.learning import learned
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import controller_of, load_design, machine, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.motion.contour import Contour, contour, contour_meanings, contour_metrics, during
from hfc_design.motion.program import Program
from hfc_design.motion.samples import Samples
from hfc_design.motion.tool_path import program_errors
from hfc_design.objectives import metrics
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.program_metrics import (
    AxisAlong,
    length_unit,
    program_meanings,
    program_metrics,
)
from hfc_design.simulation import memory, population
from hfc_design.simulation.closed_loop import Loop, Recorded, closed_loop
from hfc_design.simulation.divergence import divergence_of, finer
from hfc_design.simulation.evaluation import EVALUATED, AxisMotion, Evaluation
from hfc_design.simulation.population import Machines
from hfc_design.simulation.repeats import averaged, louder, repeats_of, together
from hfc_design.simulation.stepping import Motions
from plants.around import plain


def evaluate(design: AnyDesign, scenario: AnyScenario) -> Evaluation:
    """Simulate ``design`` on ``scenario``.

    The plant is the design's, with the parameters that the scenario sets laid over it. A motion
    that diverges is simulated again in finer steps, so that it is the loop that is judged and not
    the step. Beside it stand its ``repeats``, which tell whether it is chaotic.

    Raises:
        UserError: the two are made for different plants or sample times, or it needs more memory
            than there is.
    """
    design = load_design(design)
    scenario = with_converter(load_scenario(scenario), design)
    memory.check(scenario.name, memory.of_motion(scenario))
    machines = population.one_machine(machine(design, scenario).values())
    controller, gains = controller_of(design, scenario)
    found: dict[int, Evaluation] = {}
    waiting = list(range(len(scenario.each_motion())))
    for where in chain([scenario], finer(scenario)):
        motions = [where.each_motion()[k] for k in waiting]
        loop, many = louder(closed_loop(where, controller), gains)
        each = evaluations(motions, loop, machines, many)
        found |= {k: own for k, (own,) in zip(waiting, each, strict=True)}
        waiting = [k for k in waiting if found[k].diverged]
        if not waiting:
            break
    if not scenario.motions:
        return found[0]
    names = (motion.name for motion in scenario.motions)
    return _together(scenario, {name: found[k] for k, name in enumerate(names)})


def learned_in(design: AnyDesign, scenario: AnyScenario, evaluation: Evaluation) -> Design:
    """The design with what it has learnt in the motion of its ``evaluation`` on a scenario.

    Of several motions that is the first; the others are in ``evaluation.motions``.

    Raises:
        UserError: it does not adapt, has diverged, or the evaluation is of another controller.
    """
    wanted(evaluation, Evaluation, EVALUATED)
    design, axes = load_design(design), evaluation.machine.axes
    begun = within_rate(design.commanding(axes).initial_memory(0.0))
    remembered: list[Memory] = [begun, within_rate(evaluation.memory)]
    own, found = map(str, map(jax.tree.structure, remembered))
    if found != own:
        why = "the evaluation is of another controller: what it remembers has other parts"
        raise UserError(f"design {design.name}: {why}")
    told = {"scenario": load_scenario(scenario).name, "samples": len(evaluation.time)}
    return learned(design, axes, evaluation.memory, told)


def evaluations(
    motions: Sequence[Scenario], loop: Loop, machines: Machines, gains: Gains
) -> Iterator[Iterator[Evaluation]]:
    """Of each motion what is read off that of each of ``machines``, all simulated together.

    On a single machine ``gains`` may be those of ``louder``.
    """
    samples = [motion.samples() for motion in motions]
    found = population.motions_and_memories(loop, machines, samples, gains, machines.size)
    for motion, happens, moved in zip(motions, samples, found, strict=True):
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
    own, time = loop.machine, scenario.simulation.time
    many = len(judged.merit) > machines.size
    for k in range(machines.size):
        true = tuple(map(plain, machines.true))
        parameters = jax.tree.map(lambda leaf, k=k: float(leaf[k]), true)
        moved = jax.tree.map(lambda leaf, k=k: leaf[:, k], motions)
        each = zip(own.axes, own.drives, parameters, samples.axes, moved, strict=True)
        axes = tuple(starmap(AxisMotion, each))
        path = _contour(scenario, axes)
        parts = (slice(None), *(window.part(scenario.simulation) for window in scenario.windows))
        values = (value for part in parts for value in _metrics(scenario, axes, path, part))
        numbers = (x if x is not None and np.isfinite(x) else None for x in values)
        found = dict(zip(meanings(scenario), numbers, strict=True))
        diverged = bool(judged.failed[k]) or not all(
            np.isfinite(part).all()
            for axis in axes
            for part in (axis.motion.error, axis.motion.command, axis.velocity)
        )
        scores = (float(judged.values[k, 0]), float(judged.merit[k]))
        fitness, merit = (-np.inf, -np.inf) if diverged else scores
        lost = divergence_of(time, _quantities(axes)) if diverged else None
        whole = Evaluation(fitness, merit, diverged, own, found, time, axes, path)
        again = repeats_of(judged) if many else {}
        memory = jax.tree.map(lambda leaf, k=k: float(leaf[k]), memories)
        whole = whole._replace(substeps=loop.substeps, divergence=lost, repeats=again)
        yield whole._replace(memory=memory)


def _together(scenario: Scenario, motions: dict[str, Evaluation]) -> Evaluation:
    """One evaluation of several motions: costs are averaged by their weights."""
    first, *_ = motions.values()
    lost = [one for one in motions.values() if one.diverged]
    weights = np.array([motion.weight for motion in scenario.motions])

    def mean(merits: list[float]) -> float:
        return float(averaged(np.array([merits]), weights)[0])

    metrics = {
        f"{_key(name)}_{key}": value
        for name, one in motions.items()
        for key, value in one.metrics.items()
    }
    return (lost[0] if lost else first)._replace(
        fitness=mean([one.fitness for one in motions.values()]),
        merit=mean([one.merit for one in motions.values()]),
        metrics=metrics,
        motions=motions,
        repeats=together([one.repeats for one in motions.values()], weights),
    )


def _quantities(axes: tuple[AxisMotion, ...]) -> dict[str, Floats]:
    """Every state of the machine and then the commands, (steps,) each, by name."""
    several = len(axes) > 1
    heads = [f"{axis.name}: " if several else "" for axis in axes]
    pairs = [*zip(heads, axes, strict=True)]
    states = {
        head + key: x for head, axis in pairs for key, x in axis.motion.state._asdict().items()
    }
    return states | {f"{head}the command": axis.motion.command for head, axis in pairs}


def _metrics(
    scenario: Scenario, axes: tuple[AxisMotion, ...], path: Contour | None, part: slice
) -> list[float | None]:
    """Every metric of a part of the motion, in the order of ``meanings``."""
    time = scenario.simulation.time
    motions = [jax.tree.map(lambda leaf: leaf[part], axis.motion) for axis in axes]
    if path is not None and isinstance(path.trajectory, Program):
        pairs = zip(axes, motions, strict=True)
        along = [_along(scenario, axis, motion, part) for axis, motion in pairs]
        return [*program_metrics(path.trajectory, during(path, time, part), along).values()]
    if path is not None:
        errors = np.stack([motion.error for motion in motions])
        commands = np.stack([motion.command for motion in motions])
        inside = during(path, time, part)
        return list(
            contour_metrics([axis.drive for axis in axes], inside, errors, commands).values()
        )
    found: list[float | None] = []
    for axis, motion in zip(axes, motions, strict=True):
        speeds = axis.velocity[part], axis.happens.reference_rate[part]
        settled = scenario.fitness.settled_after_s
        found += metrics.metrics(axis.drive, motion, *speeds, time[part], settled).values()
    return found


def _along(scenario: Scenario, axis: AxisMotion, motion: Recorded, part: slice) -> AxisAlong:
    """What there is to read off one axis in a part of a program."""
    reference = axis.reference[part]
    limit = scenario.limits.of(axis.name).command
    limits = axis.drive.largest_commands(axis.parameters, limit)
    seen = (reference - motion.error, axis.velocity[part], motion.command)
    return AxisAlong(axis.name, axis.drive, reference, *seen, limits)


def meanings(scenario: Scenario) -> dict[str, str]:
    """Meaning and unit of every metric that an evaluation on a scenario has."""
    if scenario.motions:
        pairs = zip(scenario.motions, scenario.each_motion(), strict=True)
        return {
            f"{_key(motion.name)}_{key}": f"{motion.name}: {text}"
            for motion, alone in pairs
            for key, text in meanings(alone).items()
        }
    machine = scenario.machine
    if isinstance(scenario.path, Program):
        own = program_meanings(machine)
    elif scenario.follows_path:
        own = contour_meanings(machine.drives)
    else:
        axes = machine.axes if len(machine.axes) > 1 else ("",)
        each = zip(axes, map(metrics.meanings, machine.drives), strict=True)
        own = {key: text for axis, found in each for key, text in _headed(axis, found).items()}
    names = ("", *(window.name for window in scenario.windows))
    return {key: text for name in names for key, text in _headed(name, own).items()}


def _key(motion: str) -> str:
    """A motion as it stands before a metric's name."""
    return motion.replace("-", "_")


def _headed(name: str, found: dict[str, str]) -> dict[str, str]:
    """Keys and texts with a name before them; as they are where it is ""."""
    return {f"{name}_{key}": f"{name}: {text}" for key, text in found.items()} if name else found


def _contour(scenario: Scenario, axes: tuple[AxisMotion, ...]) -> Contour | None:
    """How far a machine was off its path; None where it follows none."""
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
