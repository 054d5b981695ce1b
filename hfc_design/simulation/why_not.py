"""Changes that would give the answer yes, one at a time, from the metrics of unseen machines.

The effect of looser constraints is known from the metrics of the machines, that of a smaller
tolerance of one parameter from the machines that were drawn within it. For a smaller spread of all
parameters the machines are moved nearer to the nominal one and simulated again.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from itertools import chain
from math import ceil
from typing import TypeAlias

import jax
import numpy as np
from scipy.stats import mannwhitneyu

from hfc_design.core.numbers import Floats, Json, Mask, Parameters
from hfc_design.core.quantities import WRITTEN
from hfc_design.core.records import UserError
from hfc_design.core.statistics import holm
from hfc_design.core.wording import three_digits
from hfc_design.files.robust import AROUND, RobustSettings
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import AxisSamples
from hfc_design.objectives.constraints import Constraint
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.metrics import RUNNING
from hfc_design.simulation.acceptance import ENOUGH, bounds_of, broken_by
from hfc_design.simulation.population import Machines
from hfc_design.simulation.stability_criteria import counted, largest_reference
from hfc_design.stability.margins import ASKED
from hfc_design.stability.nominal import nominal
from plants import Drive

#: Fewest machines within a tolerance, and fewest failing machines, for a statement about them.
LEAST, FEWEST = 100, 8
#: Significance level at which failing machines are said to differ from the others.
CHANCE = 0.01
#: Share of the largest deviation above which their median deviation is reported.
END = 0.25
#: Halvings in the search for a smaller spread; failing machines whose needed command is computed.
HALVED, SOME = 3, 64
#: Share of a limit above which the command or speed that a motion needs is reported.
NEAR = 0.7
#: Largest limit of ``late_error`` that is proposed, as a share of the largest reference.
LOOSEST = 0.2
#: Most rows of changes, and most lines of one kind.
ROWS, LINES = 8, 3
#: Factors before rounding up or down to three digits; least divisor, in place of a limit of 0.
UP, DOWN, TINY = 1.005, 0.995, 1e-300

#: Key, its value now, value for a yes, number of machines that it fails, share that pass without.
Change: TypeAlias = tuple[str, str, str | None, int | None, float]


def why_not(
    scenario: Scenario,
    robust: RobustSettings,
    machines: Machines,
    judged: Judged,
    again: Callable[[Machines], Judged],
    short: Mapping[str, tuple[float | None, str]],
) -> Json:
    """Return changes, each with its effect alone, the best first, and lines to show below them.

    ``judged`` (machines, motions) has the results of ``machines``, the nominal one first; ``again``
    judges other machines in the same loop; ``short`` has the margins that are too small.
    """
    lost, off, candidates = broken_by(scenario, judged), deviations(machines), list[Change]()
    if short:  # no other change of the scenario mends it
        (name, (value, _)), *more = short.items()
        bad = failing(scenario, lost)
        lost["is unstable at rest"] = np.indices(judged.failed.shape)[0] == 0
        if value and not more and not bad[0] and bad[1:].mean() <= 1.0 - ENOUGH:
            needed = three_digits((UP if ASKED[name][1] else DOWN) * value)
            setting = f"constraints.{name}", str(scenario.constraints[name])
            candidates.append((*setting, needed, None, 1.0 - bad[1:].mean()))
    bad, lines = failing(scenario, lost), list[str]()
    candidates += [*_constraints(scenario, judged, lost), *_motions(scenario, lost)]
    if not bad[0]:
        pairs = not any(one[2] == "nominal" for one in candidates)
        spread, lines = _spread(scenario, robust, machines, again, bad, pairs)
        candidates += [spread, *_tolerances(robust, off, bad[1:])]
    keys, share = ("key", "now", "needed", "lost", "without"), 1.0 - bad[1:].mean()
    candidates = [one for one in candidates if one[2] or one[4] > share]
    candidates.sort(key=lambda one: (one[2] is None, -one[4]))
    if not any(one[2] for one in candidates):
        lines = ["none of the single changes tried gives a yes", *lines]
    lines += [*_alike(scenario, lost, off), *_needs(scenario, machines, lost)]
    changes = [dict(zip(keys, one, strict=True)) for one in candidates[:ROWS]]
    return {"changes": changes, "lines": lines}


def failing(scenario: Scenario, lost: Mapping[str, Mask], but: int | None = None) -> Mask:
    """Return which machines (machines,) fail in a motion that is required of them.

    ``lost``: reason -> (machines, motions). Motion ``but`` is required of the nominal one only.
    """
    bad, required = np.logical_or.reduce([*lost.values()]), ~np.array(scenario.nominal_only)
    required = required & (np.arange(len(required)) != but)
    return np.append(bad[0].any(), (bad[1:] & required).any(axis=1))


def least(values: Floats, others: Mask) -> float | None:
    """Return the smallest limit on values (machines,) with which enough pass, also the nominal one.

    ``others`` (machines,) fail for other reasons. None: too many of them do.
    """
    ranked = np.sort(np.where(others[1:], np.inf, values[1:]))
    most = float(max(ranked[ceil(ENOUGH * len(ranked) - 1e-9) - 1], values[0]))
    return most if np.isfinite(most) and not others[0] else None


def widest(off: Floats, bad: Mask) -> tuple[float, int] | None:
    """Return the largest distance within which enough machines pass, and how many are within it.

    ``off`` has the distances (machines,). None: there is none with at least ``LEAST`` machines.
    """
    order, count = np.argsort(off, kind="stable"), np.arange(1, len(off) + 1)
    good = (np.cumsum(~bad[order]) >= ENOUGH * count - 1e-9) & (count >= LEAST)
    return (float(off[order][good][-1]), int(count[good][-1])) if good.any() else None


def _constraints(scenario: Scenario, judged: Judged, lost: Mapping[str, Mask]) -> Iterator[Change]:
    required, late = ~np.array(scenario.nominal_only), RUNNING["late_error"]
    bounds = bounds_of(scenario, judged)
    ways = min(map(largest_reference, scenario.each_motion()))
    if lost["is far off"].any():  # without a constraint: beyond 5 % of the reference, say
        bounds.setdefault(late.name, (Constraint(late, 0.0), np.asarray(judged.values)[..., -1]))
    for name, (bound, values) in bounds.items():
        reasons = [f"exceeds {name}", "is far off"][: 1 + (name == late.name)]
        others = failing(scenario, {why: x for why, x in lost.items() if why not in reasons})
        worst = np.append(values[0].max(), np.where(required, values[1:], -np.inf).max(axis=1))
        most, limit = least(worst, others), scenario.constraints.get(name, "-")
        if name == late.name and most and most > LOOSEST * ways:
            most = None
        written, unit = WRITTEN.fullmatch(str(limit).strip()), bound.metric.unit
        unit = written[2] if written and bound.most else scenario.units.signals.get(unit, unit)
        scale = float(written[1]) / bound.most if written and bound.most else 1.0
        needed = most and f"{three_digits(UP * most * scale)} {unit}".removesuffix(" 1")
        count = failing(scenario, {why: x for why, x in lost.items() if why in reasons})[1:].sum()
        now = str(limit) if written or limit == "-" else f"{limit} {unit}".removesuffix(" 1")
        yield f"constraints.{name}", now, needed or None, int(count), 1.0 - others[1:].mean()


def _motions(scenario: Scenario, lost: Mapping[str, Mask]) -> Iterator[Change]:
    """Yield the changes that require one motion of the nominal machine only."""
    bad, required = np.logical_or.reduce([*lost.values()]), ~np.array(scenario.nominal_only)
    for k in np.flatnonzero(required).tolist() if required.sum() > 1 else ():
        others = failing(scenario, lost, k)
        without, key = 1.0 - others[1:].mean(), f"motions.{scenario.motions[k].name}.machines"
        enough = without >= ENOUGH and not others[0]
        yield key, "all", "nominal" if enough else None, int(bad[1:, k].sum()), without


def _tolerances(robust: RobustSettings, off: Mapping[str, Floats], bad: Mask) -> Iterator[Change]:
    """Yield a smaller tolerance of each parameter on which it depends whether machines pass."""
    sizes = np.abs(np.array([*off.values()]))
    for name, size, more in zip(off, sizes, _apart(sizes, bad), strict=True):
        inner, interval = 2.0 * size <= size.max(), widest(size, bad)
        if more > 0.0 and inner.sum() >= LEAST:
            now = three_digits(robust.tolerances.get(name, robust.spread))
            proposed = interval and f"{three_digits(DOWN * interval[0])} ({interval[1]})"
            yield f"robust.tolerances.{name}", now, proposed, None, 1.0 - bad[inner].mean()


def _spread(
    scenario: Scenario,
    robust: RobustSettings,
    machines: Machines,
    again: Callable[[Machines], Judged],
    bad: Mask,
    pairs: bool,
) -> tuple[Change, list[str]]:
    """Return the change that reduces all tolerances; ``pairs``: also a line with a motion less."""

    @cache
    def lost(part: float) -> dict[str, Mask]:
        return broken_by(scenario, again(nearer(machines, part)))

    def passing(part: float, but: int | None) -> float:
        return float(1.0 - failing(scenario, lost(part), but)[1:].mean())

    def largest(but: int | None = None) -> float:
        fraction, step = 0.0, 0.5
        for _ in range(HALVED):
            fraction += step * (passing(fraction + step, but) >= ENOUGH)
            step *= 0.5
        return fraction * robust.spread

    alone, key = largest(), "robust.spread" + ", tolerances in proportion" * bool(robust.tolerances)
    change = key, three_digits(robust.spread), f"{alone:.4g}" if alone else None
    row = (*change, int(bad[1:].sum()), passing(0.5, None))
    if not pairs or (~np.array(scenario.nominal_only)).sum() < 2:
        return row, []
    best = max(range(len(scenario.motions)), key=lambda k: passing(0.5, k))
    most, key = largest(best), f"motions.{scenario.motions[best].name}.machines nominal, {key}"
    return row, [f"both changes together: {key} {most:.4g}"] * (most > alone)


def nearer(machines: Machines, part: float) -> Machines:
    """Return the machines moved towards the first of them, to a ``part`` of their distance."""
    values = (machines.actual, dict(machines.around))
    moved = jax.tree.map(lambda x: x[..., :1] + part * (x - x[..., :1]), values)
    return Machines(machines.nominal, *moved)


def deviations(machines: Machines) -> dict[str, Floats]:
    """Return relative deviations of each varying parameter (machines,), without the nominal one.

    Deviations of effects around the drives are in their own units. Of several axes the one with the
    largest deviation counts.
    """
    each: dict[str, list[Floats]] = {}
    for name, x in chain.from_iterable(one._asdict().items() for one in machines.actual):
        if np.ptp(x):
            each.setdefault(name, []).append(x[1:] / x[0] - 1.0)
    each |= {name: [*(x[:, 1:] - x[:, :1])] for name, x in machines.around.items()}
    many = {name: np.array(x) for name, x in each.items()}
    return {key: x[np.abs(x).argmax(axis=0), np.arange(x.shape[1])] for key, x in many.items()}


def _apart(values: Floats, bad: Mask) -> Floats:
    """Return effect sizes (rows,), -1 to 1; above 0: ``bad`` machines have the larger values.

    0: it may be chance, by a test of ranks (Mann & Whitney 1947) corrected for the number of rows.
    """
    if not len(values) or min(bad.sum(), (~bad).sum()) < FEWEST:
        return np.zeros(len(values))
    ranks = mannwhitneyu(values[:, bad], values[:, ~bad], axis=1)
    shares = ranks.statistic / (bad.sum() * (~bad).sum())
    return np.where(holm(np.asarray(ranks.pvalue)) < CHANCE, 2.0 * shares - 1.0, 0.0)


def _alike(
    scenario: Scenario, lost: Mapping[str, Mask], off: Mapping[str, Floats]
) -> Iterator[str]:
    """Yield the most frequent failures in a motion, with extreme parameters of failing machines."""
    required, values, names = ~np.array(scenario.nominal_only), np.array([*off.values()]), [*off]
    around = AROUND.keys() - {name for one in scenario.plant.values() for name in one._fields}
    faults = [(x[1:, k], why, k) for why, x in lost.items() for k in np.flatnonzero(required)]
    failures = [one for one in faults if one[0].any() and not one[1].startswith("exceeds ")]
    for bad, why, k in sorted(failures, key=lambda one: -one[0].sum())[:LINES]:
        more = _apart(values, bad)
        ends = []
        for n in np.argsort(-np.abs(more))[:LINES]:
            middle = float(np.median(values[n, bad]))
            if not more[n] or abs(middle) < END * np.abs(values[n]).max():
                continue
            size = f"{middle:+.2g}" if names[n] in around else f"{100 * middle:+.0f} %"
            ends.append(f"{'high' if more[n] > 0 else 'low'} {names[n]} ({size})")
        where = f" in {scenario.motions[k].name}" if scenario.motions else ""
        alike = f", mostly with {', '.join(ends)}" if ends else ""
        yield f"{counted(bad.sum(), why)}{where}{alike}"


def _needs(scenario: Scenario, machines: Machines, lost: Mapping[str, Mask]) -> Iterator[str]:
    """Yield lines on commands and speeds that motions need, if they are near a limit or above."""
    bad, saturated = np.logical_or.reduce([*lost.values()]), lost["stays at a limit"]
    low: dict[str, float] = {}
    each_samples = [motion.samples().axes for motion in scenario.each_motion()]
    speeds = np.array([[_highest(axis) for axis in axes] for axes in each_samples]).max(axis=0)
    for k, motion in enumerate(scenario.each_motion()):
        worst, every = np.flatnonzero(bad[1:, k])[:SOME] + 1, motion.simulation.sample_time_s
        axes = zip(motion.plant.each(), machines.actual, each_samples[k], speeds, strict=True)
        for axis, parameters, samples, speed in axes:
            most, drive = motion.limits.of(axis.name).command, axis.drive
            some = [type(parameters)(*(float(x[i]) for x in parameters)) for i in (0, *worst)]
            pairs = np.array([needed(drive, x, samples, most, every, speed) for x in some])
            for n, unit in enumerate(("command", "error_rate")):
                share = np.nan_to_num(pairs[:, n, 0] / np.maximum(pairs[:, n, 1], TINY))
                name = motion.name.rpartition(".")[2] + f" {axis.name}" * (len(machines.actual) > 1)
                if share.max() <= NEAR:
                    low |= {name: share.max()} if saturated[:, k].any() and n == 0 else {}
                    continue
                each = [" of ".join(map(three_digits, one)) for one in pairs[:, n]]
                line = f"{name} needs {each[0]} {drive.units[unit]} on the nominal machine"
                if len(worst):
                    top = each[1 + share[1:].argmax()]
                    line += f", {top} on the worst of {len(worst)} that fail"
                beyond = int((share[1:] > 1.0).sum())
                yield line + f": beyond the limit on {beyond} of them" * (beyond > 0)
    if low:
        line = f"at a limit, although at most {100 * max(low.values()):.0f} % of it is needed"
        yield f"{line}: {', '.join(low)}"


def _highest(motion: AxisSamples) -> float:
    return float(np.abs(motion.reference_rate).max())


def needed(
    drive: Drive,
    parameters: Parameters,
    motion: AxisSamples,
    most: float | None,
    every: float,
    speed: float = 0.0,
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return command and speed that a motion needs, each with its limit; nan: no steady motion.

    They are computed with the drive linearised at the highest speed of the motion, in samples of
    ``every`` s, without the additional command for an elastic transmission or a rising current.
    For a motion that stands still it is linearised at ``speed``, if that is not 0.
    """
    rate, command = np.asarray(motion.reference_rate), np.full(len(motion.reference_rate), np.nan)
    highest = _highest(motion)
    with suppress(UserError):
        for way in np.unique(np.sign(rate[rate != 0.0])).tolist() or [1.0]:
            model = nominal(drive, parameters, every, way * (highest or float(speed)) or None)
            demand = model.velocity.command * rate + model.load.command * motion.loads[0]
            demand += model.coulomb.command * (rate != 0.0)
            if motion.reference_acceleration is not None:
                demand += model.acceleration.command * motion.reference_acceleration
            command = np.where(way * rate >= 0.0, demand, command)
    low, high = drive.largest_commands(parameters, most)
    pairs = (float(np.fmax.reduce(command)), high), (-float(np.fmin.reduce(command)), -low)
    worst = max(pairs, key=lambda one: one[0] / max(one[1], TINY))
    return worst, (highest, drive.top_speed(parameters))
