"""Stress tests of a design: disturbances that engineers expect and scenarios do not contain.

They are applied one at a time to some of the machines, in all motions, by the compiled program that
also simulates the machines without stress. Most are effects around the drives (``plants.around``),
so that no plant has to model them; a load, a start and a rest are other samples of the motions.
"""

import operator
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.core.numbers import Floats, Gains, Integers, Mask
from hfc_design.core.records import UserError
from hfc_design.core.wording import three_digits
from hfc_design.files.machine import Axis
from hfc_design.files.motions import put, way
from hfc_design.files.robust import friction_of
from hfc_design.files.scenario import Scenario
from hfc_design.files.stress import MODES, Mode
from hfc_design.motion.phases import late_samples
from hfc_design.motion.samples import Samples
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.metric import in_units
from hfc_design.simulation import population
from hfc_design.simulation.acceptance import Stressed
from hfc_design.simulation.closed_loop import Loop
from hfc_design.simulation.population import Machines, standing
from hfc_design.simulation.repeats import of_all_motions
from hfc_design.simulation.stability_criteria import instabilities
from hfc_design.stability.nominal import nominal
from plants.around import Standing, plain

#: Parts of a stress that are tried where the whole breaks the design.
PARTS = np.arange(1, 8) / 8.0
#: Share of the largest command that holds the load of the stress, if the scenario has no load.
HELD = 0.1
#: One of this number of machines in a search is under stress.
EVERY = 2
#: If a share is within CLOSE of the required share, MORE times as many machines decide.
CLOSE, MORE = 0.06, 4
#: Pairs of a stress and a machine that are simulated together.
AT_ONCE = 64


class Applied(NamedTuple):
    """Changes that a stress of a certain size makes."""

    around: dict[str, Any] = {}  # fields of ``plants.around.Around``, for every axis
    friction: float = 1.0  # factor on all friction
    sticking: float = 0.0  # more friction at rest, as a share of the Coulomb friction
    samples: Callable[[Samples], Samples] | None = None  # change of the samples of a motion


class Case(NamedTuple):
    """One stress; parts of it can be tried."""

    words: str  # with {} for its size
    size: float
    applied: Callable[[float], Applied]  # size -> changes
    shown: float = 1.0  # factor on the size in ``words``
    factor: bool = False  # whether the size is a factor, so that its half is the square root

    @property
    def applies(self) -> bool:
        """Whether the stress changes anything."""
        return self.size != float(self.factor)

    def of(self, part: float) -> float:
        """Return the size of a part (0 to 1) of the stress."""
        return self.size**part if self.factor else self.size * part

    def description(self, part: float) -> str:
        """Return a part (0 to 1) of the stress in words."""
        return self.words.format(three_digits(self.shown * self.of(part)))


def stressed(
    scenario: Scenario,
    loop: Loop,
    gains: Gains,
    machines: Machines,
    baseline: Judged,
    crossover: float | None,
) -> tuple[Stressed, ...]:
    """Test a design under every stress in ``[stress]`` of the scenario.

    ``loop`` must allow effects around its drives. ``baseline`` (machines, motions) has the results
    of the ``machines`` without stress, the nominal one first. ``crossover`` is the frequency at
    which the loop has the magnitude 1 [Hz]; None: unknown.
    """
    settings = scenario.stress
    counts = np.minimum([settings.machines, MORE * settings.machines], machines.size)
    some, many = (machines.take(np.arange(count)) for count in counts)
    each = [one for one in cases(scenario, crossover) if one.applies]
    judged = _judged(scenario, loop, some, gains, [(case, 1.0) for case in each])
    holding = _holding(scenario, baseline)
    shares = [_share(holding(one)[0]) for one in judged]
    close = [k for k, share in enumerate(shares) if abs(share - settings.share) < CLOSE]
    again = _judged(scenario, loop, many, gains, [(each[k], 1.0) for k in close])
    for k, one in zip(close, again, strict=True):
        judged[k] = one
    broken = [k for k, one in enumerate(judged) if not _enough(scenario, holding(one)[0])]
    tried = [(each[k], float(part)) for k in broken for part in PARTS]
    less = iter(_judged(scenario, loop, some, gains, tried))
    rows = []
    for k, (case, whole) in enumerate(zip(each, judged, strict=True)):
        passing, _ = holding(whole)
        without = Judged(*(part[: len(whole.failed)] for part in baseline))
        worth = 0.0 if k in broken else _worth(scenario, whole) / _worth(scenario, without)
        row = Stressed(case.description(1.0), k not in broken, _share(passing), worth)
        parts = [(part, next(less)) for part in PARTS] if k in broken else []
        for part, one in (*parts, (1.0, whole)):
            passing, why = holding(one)
            if not _enough(scenario, passing):
                row = row._replace(part=float(part), breaks=case.description(float(part)), why=why)
                break
            if parts:
                row = row._replace(held=case.description(float(part)))
        rows.append(row)
    return tuple(rows)


def among(machines: Machines, scenario: Scenario, loop: Loop) -> tuple[Machines, Integers]:
    """Return the machines, every ``EVERY``-th of them under a stress, the stresses in turn.

    The second result has the indices of the machines without stress. Stresses that change only the
    motion are left out; a load acts from the beginning of the motion.
    """
    each = [one for one in cases(scenario, None) if one.applies]
    kinds = [one for one in each if one.applied(one.size)._replace(samples=None) != Applied()]
    under = np.full(machines.size, -1)  # no stress
    if kinds:
        under[1::EVERY] = np.arange(len(under[1::EVERY])) % len(kinds)
    parts = []
    for k, case in enumerate([None, *kinds], -1):
        one = case.applied(case.size) if case else Applied()
        some = rubbing(scenario, machines.take(np.flatnonzero(under == k)), one)
        parts.append(standing(some, scenario, loop, one.around).actual)
    order = np.argsort(np.argsort(under, kind="stable"))
    true = jax.tree.map(lambda *leaves: np.concatenate(leaves)[order], *parts)
    return Machines(machines.nominal, true), np.flatnonzero(under < 0)


def _enough(scenario: Scenario, passing: Mask) -> bool:
    """Whether the nominal machine (the first) and a sufficient share of all stay stable."""
    return bool(not len(passing) or (passing[0] and _share(passing) >= scenario.stress.share))


def _share(passing: Mask) -> float:
    return float(passing.mean()) if len(passing) else 1.0


def _holding(scenario: Scenario, without: Judged) -> Callable[[Judged], tuple[Mask, str]]:
    """Return a function that tells which machines stay stable, and how and where others fail."""
    motions, required = scenario.each_motion(), ~np.array(scenario.nominal_only)

    def lost(one: Judged) -> dict[str, Mask]:
        values = np.concatenate([without.values[:1], one.values])
        failed = np.concatenate([without.failed[:1], one.failed])
        reasons = instabilities(values, failed, motions)
        return {why: mask[1:] & required for why, mask in reasons.items()}

    before = ~np.logical_or.reduce([*lost(without).values()]).any(axis=1)

    def holding(judged: Judged) -> tuple[Mask, str]:
        reasons = {why: mask[before[: len(mask)]] for why, mask in lost(judged).items()}
        holds = ~np.logical_or.reduce([*reasons.values()]).any(axis=1)
        why = max(reasons, key=lambda name: reasons[name].any(axis=1).sum())
        where = int(reasons[why].sum(axis=0).argmax())
        return holds, why + (f" in {scenario.motions[where].name}" if scenario.motions else "")

    return holding


def _worth(scenario: Scenario, judged: Judged) -> float:
    """Return the merit of the median machine over all motions."""
    return float(np.median(of_all_motions(scenario, judged.rank)))


def longest(scenario: Scenario) -> int:
    """Return the samples of all motions in sum, each with the longest rest a stress adds."""
    each = [motion.simulation for motion in scenario.each_motion()]
    rest = scenario.stress.rest_s
    return sum(x.steps + max(x.steps, round(rest / x.sample_time_s)) for x in each)


def _judged(
    scenario: Scenario,
    loop: Loop,
    machines: Machines,
    gains: Gains,
    tried: Sequence[tuple[Case, float]],
) -> list[Judged]:
    """Return results (machines, motions) of each part of a stress; equal motions run together."""
    plainly = [motion.samples() for motion in scenario.each_motion()]
    results: dict[int, Judged] = {}
    groups: dict[Any, list[tuple[int, Machines, Applied]]] = {}
    for k, (case, part) in enumerate(tried):
        applied = case.applied(case.of(part))
        one = standing(rubbing(scenario, machines, applied), scenario, loop, applied.around)
        groups.setdefault(applied.samples, []).append((k, one, applied))
    for group in groups.values():
        change = group[0][2].samples
        motions = [*map(change, plainly)] if change else plainly
        true = jax.tree.map(lambda *x: np.concatenate(x), *(one.actual for _, one, _ in group))
        many, dtype = Machines(machines.nominal, true), scenario.run.precision
        about = (gains, dtype, AT_ONCE, longest(scenario))
        judged = population.scores(loop, many, motions, *about)
        for n, (k, *_) in enumerate(group):
            here = slice(n * machines.size, (n + 1) * machines.size)
            results[k] = Judged(*(np.array(part[0, here]) for part in judged))
    return [results[k] for k in range(len(tried))]


def rubbing(scenario: Scenario, machines: Machines, what: Applied) -> Machines:
    """Return the machines with their friction multiplied, and with more friction at rest."""
    if what.friction == 1.0 and not what.sticking:
        return machines
    true = []
    for drive, parameters in zip(scenario.machine.drives, machines.actual, strict=True):
        bare = plain(parameters)
        more = {name: what.friction * getattr(bare, name) for name in friction_of(drive)}
        coulomb = what.sticking * sum(x for name, x in more.items() if "coulomb" in name)
        more |= {name: more[name] + coulomb for name in friction_of(drive, moving=False)}
        bare = bare._replace(**more)
        true.append(parameters._replace(inner=bare) if isinstance(parameters, Standing) else bare)
    return Machines(machines.nominal, tuple(true))


def cases(scenario: Scenario, crossover: float | None) -> Iterator[Case]:
    """Yield every stress in ``[stress]``; one that does not apply has a size without effect."""
    stress, every = scenario.stress, scenario.simulation.sample_time_s
    axes = scenario.plant.each()
    sensors = [scenario.sensors.of(axis.name) for axis in axes]
    pairs = zip(axes, sensors, strict=True)
    steps = np.array([axis.resolution or sensor.encoder_resolution for axis, sensor in pairs])
    also = scenario.robust.tolerances if scenario.robust else {}
    each: list[Any] = [y for x in sensors for y in (x, *x.readings.values())]
    noisy = "noise" not in also and any(one.noise for one in each)
    rubbing = any(friction_of(axis.drive) for axis in axes)
    later = stress.delay_samples * ("delay_samples" not in also)
    yield Case("a delay {} samples longer", later, _around("delay_samples"))
    yield Case("a current loop {} samples slower", stress.lag_samples, _around("lag_s", every))
    yield Case("{} times the noise", stress.noise if noisy else 1.0, _around("noise"), factor=True)
    for size in (stress.friction, 1.0 / stress.friction):
        rubbed = partial(Applied, {})
        yield Case("{} times the friction", size if rubbing else 1.0, rubbed, factor=True)
    sticks = stress.sticking * any(friction_of(axis.drive, moving=False) for axis in axes)
    rests = "{} % more Coulomb friction at standstill"
    yield Case(rests, sticks, lambda size: Applied(sticking=size), 100.0)
    yield from _modes(scenario, crossover)
    gap = stress.backlash_steps * steps.any()
    yield Case("a backlash of {} encoder steps", gap, _around("backlash", steps))
    yield Case("samples up to {} % early or late", stress.jitter, _around("jitter"), 100.0)
    yield from _loads(scenario, "load" not in also)
    begun = _other(partial(_started, scenario))
    yield Case("a start {} % of the motion off", stress.start, begun, 100.0)
    yield Case("{} s at rest after the motion", stress.rest_s, _other(_resting))
    back = stress.backwards * all(motion.path is None for motion in scenario.each_motion())
    yield Case("every motion {} % backwards", back, _other(_turned), 100.0)


def _around(key: str, scale: Any = 1.0) -> Callable[[float], Applied]:
    return lambda size: Applied({key: size * scale})


def _other(change: Callable[..., Samples]) -> Callable[[float], Applied]:
    return lambda size: Applied(samples=partial(change, size=size))


def _modes(scenario: Scenario, crossover: float | None) -> Iterator[Case]:
    """Yield the stresses by modes: known ones, and possible ones of each inertia and frequency."""
    stress = scenario.stress

    def mode(one: Mode, words: str, size: float, share: Callable[[float], float]) -> Case:
        def swings(part: float) -> Applied:
            changes = {"mode_hz": one.hz, "mode_damping": one.damping, "mode_share": share(part)}
            return Applied(changes)

        title = f"a mode at {three_digits(one.hz)} Hz{words}"
        return Case(title, size, swings, 100.0)

    for one in stress.modes:
        shown = partial(operator.mul, one.share)
        yield mode(one, " as in stress.modes, {} % of its share", 1.0, shown)
    ends = stress.modes_between(crossover, scenario.simulation.sample_time_s)
    frequencies = np.geomspace(*ends, MODES) if ends[0] < ends[1] else ()
    for hz in map(float, frequencies):
        one = Mode(hz=hz, damping=stress.mode_damping)
        for inertia in stress.mode_inertia:
            yield mode(one, ", {} % of the moving inertia", inertia, lambda r: r / (1.0 - r))
        if stress.far_modes:
            yield mode(one, " before the encoder, {} % of it", 1.0, operator.neg)


def _loads(scenario: Scenario, constant: bool) -> Iterator[Case]:
    """Yield stresses by loads: none, a constant one in both directions (``constant``), a step."""
    motions = [motion.samples() for motion in scenario.each_motion()]
    loaded = any(np.any(axis.loads) for one in motions for axis in one.axes)

    def less(samples: Samples, size: float) -> Samples:
        return _pushed(samples, lambda loads, k: (1.0 - size) * loads)

    yield Case("{} % less load", float(loaded), _other(less), 100.0)
    sizes = np.array(loads(scenario))
    largest, unit = float(sizes.max()), scenario.units.signals["load"]
    shares = sizes / largest if largest else sizes
    words = f"an extra load of {{}} {unit}"
    first = partial(_load_first, scenario)

    def pushed(size: float) -> Applied:
        return Applied({"load": size * shares}, samples=first)

    for sign in (1.0, -1.0) if constant else ():
        yield Case(words, sign * largest, pushed)
    step = _other(partial(_stepped, shares=shares.tolist()))
    yield Case(f"a load step of {{}} {unit}", largest, step)


def loads(scenario: Scenario) -> list[float]:
    """Return the load of the stress on each axis; 0 where its size is unknown."""
    load, axes = scenario.stress.load, scenario.plant.each()
    if load is not None:
        return [in_units("stress.load", load, "load", scenario.units)] * len(axes)
    motions = scenario.each_motion()
    largest = [max(abs(one.load.of(axis.name).constant) for one in motions) for axis in axes]
    if not any(largest):
        every = [motion.samples().axes for motion in motions]
        largest = [max(float(np.abs(x[k].loads).max()) for x in every) for k in range(len(axes))]
    return largest if any(largest) else [_held_by_a_part(scenario, axis) for axis in axes]


def _held_by_a_part(scenario: Scenario, axis: Axis) -> float:
    """Return the load that a share ``HELD`` of the largest command can hold; 0 if unknown."""
    limit = scenario.limits.of(axis.name).command
    most = min(map(abs, axis.drive.largest_commands(axis.parameters, limit)))
    try:
        model = nominal(axis.drive, axis.parameters, scenario.simulation.sample_time_s)
    except UserError:  # it cannot be linearised
        return 0.0
    return HELD * most / abs(model.load.command) if np.isfinite(most) else 0.0


def _stepped(samples: Samples, size: float, shares: Sequence[float]) -> Samples:
    """Return samples with a load step after a third: the loop can settle until the last quarter."""
    after = (np.arange(len(samples.time)) >= len(samples.time) // 3).astype(float)
    return _pushed(samples, lambda loads, k: loads + size * shares[k] * after)


def _pushed(samples: Samples, change: Callable[[Floats, int], Floats]) -> Samples:
    axes = (x._replace(loads=change(np.asarray(x.loads), k)) for k, x in enumerate(samples.axes))
    return samples._replace(axes=tuple(axes))


def _started(scenario: Scenario, samples: Samples, size: float) -> Samples:
    """Return samples in which the machine and its copy begin away from the reference."""
    starts, copies = [], []
    each = zip(scenario.plant.each(), samples.axes, samples.start, samples.copy_start, strict=True)
    for axis, axis_samples, start, copy_start in each:
        gone = np.asarray(axis_samples.target) - getattr(start, axis.drive.position)
        off = size * way(gone, np.asarray(axis_samples.reference_rate))
        starts.append(put(axis.drive, start, off))
        copies.append(put(axis.drive, copy_start, off))
    return samples._replace(start=tuple(starts), copy_start=tuple(copies))


def _turned(samples: Samples, size: float) -> Samples:
    """Return samples of a motion in the opposite direction, with its travel times ``size``."""
    axes = []
    for axis_samples in samples.axes:
        each = {name: getattr(axis_samples, name) for name in TURNED}
        axes.append(axis_samples._replace(**jax.tree.map(lambda x: -size * np.asarray(x), each)))
    return samples._replace(axes=tuple(axes))


#: Fields of ``AxisSamples`` that change their sign in a reversed motion.
TURNED = ("reference", "reference_rate", "target", "reference_acceleration", "end", "heading")
#: Fields of ``AxisSamples`` at rest: equal to the start (before a motion), unchanged, and 0.
BEGINS = ("reference", "target")
STAYS = ("reference", "loads", "target", "end", "heading")
ENDS = ("reference_rate", "reference_acceleration", "sliding")


def _resting(samples: Samples, size: float) -> Samples:
    """Return samples with a rest of ``size`` [s] after the motion; the last load stays."""
    return _longer(samples, 0, round(size / float(samples.sample_time)))


def _load_first(scenario: Scenario, samples: Samples) -> Samples:
    """Return samples with a rest, as long as the motion, before it: the load is held first."""
    many, axes = len(samples.time), scenario.plant.each()
    longer = _longer(samples, many, 0)
    held_axes = []
    for axis, axis_samples, start in zip(axes, longer.axes, samples.start, strict=True):
        place = getattr(start, axis.drive.position)
        resting = np.arange(2 * many) < many
        each = {name: np.where(resting, place, getattr(axis_samples, name)) for name in BEGINS}
        held_axes.append(axis_samples._replace(**each))
    return longer._replace(axes=tuple(held_axes))


def _longer(samples: Samples, before: int, behind: int) -> Samples:
    """Return samples with rest ``before`` and ``behind`` the motion; metrics ignore that before."""
    steps = before + len(samples.time) + behind

    def extended(column: Floats | None, first: float = 1.0, last: float = 1.0) -> Floats | None:
        if column is None:
            return None
        column = np.asarray(column)
        ends = (first * column[..., :1], before), (last * column[..., -1:], behind)
        front, back = (np.repeat(end, count, axis=-1) for end, count in ends)
        return np.concatenate([front, column, back], axis=-1)

    axes = []
    for axis_samples in samples.axes:
        columns = {name: extended(getattr(axis_samples, name)) for name in STAYS}
        columns |= {name: extended(getattr(axis_samples, name), 0.0, 0.0) for name in ENDS}
        noise = np.take(axis_samples.noise, np.arange(steps) % len(samples.time), axis=-1)
        axes.append(axis_samples._replace(**columns, noise=noise))
    time: Floats = float(samples.sample_time) * np.arange(steps, dtype=np.float64)
    late = np.append(np.zeros(before), late_samples(time[before:]))
    rest = {"path": jax.tree.map(extended, samples.path), "late": late}
    rest |= {"axes": tuple(axes), "time": time, "settled": extended(samples.settled, 0.0)}
    return samples._replace(**rest)
