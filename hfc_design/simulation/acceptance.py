"""Answer to whether a design can be used: per motion, under stress, as a sentence, as numbers.

Pages, the terminal and READMEs are made from ``Usable.numbers``: ``usable_tables`` puts these
numbers into tables, and the functions that put them into words follow ``Usable``. The functions
that measure and those that read the measured values come last, side by side, because both rely on
the order of the values.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME_SINGLE, Floats, Gains, Json, Mask, storable
from hfc_design.core.statistics import share_interval
from hfc_design.core.tables import Table, line, table
from hfc_design.core.wording import three_digits
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import controller_of
from hfc_design.files.plausibility import LEAST_SAMPLES
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.constraints import Constraint, constraints_on
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.metric import Metric
from hfc_design.objectives.metrics import RUNNING
from hfc_design.objectives.tolerances import TolerancesSettings, tolerated
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.repeats import Repeats, chaos_text
from hfc_design.simulation.stability_criteria import STABILITY, counted, instabilities
from hfc_design.simulation.usable_tables import breaking, tables
from hfc_design.stability.report import LoopMargins
from plants import in_a_name

#: How an answer begins, the best first.
YES, ON_THIS_MODEL, NO = "yes", "on this model only", "no"
#: Least share of the unseen machines that must pass for a yes.
ENOUGH = 0.99
#: Text behind the answer for a scenario that has no stress tests.
UNTRIED = "not tested under stress, add [robust] or [stress] for that"
#: Text on an unstable loop of the nominal machine, which motions may not show.
UNSTABLE = "the loop is unstable at rest or at speed (see hfc stability)"

#: Change of the merit by rounding, or by finer time steps, from which on it needs advice.
COARSE = 0.05
#: Factors on the whole command that are tried at once, the largest of them, and the smallest.
TRIED, LARGEST_TRIED = 32, 16.0
SMALLEST_TRIED = LARGEST_TRIED ** (1.0 / TRIED - 1.0)
NOTHING: Mapping[str, float] = MappingProxyType({})


class MotionResult(NamedTuple):
    """Results of many machines in one motion, without the nominal machine."""

    name: str
    good: Mask  # (machines,) stable, and within every constraint
    reasons: dict[str, int]  # reason not to pass -> number of machines
    measured: dict[str, Floats]  # metric -> (machines,)
    nominal: dict[str, float]  # metric -> value on the nominal machine
    nominal_reasons: tuple[str, ...]  # why the nominal machine does not pass; empty: it passes
    bounds: dict[str, tuple[float, Floats]]  # constraint -> allowed, and (machines + 1,) measured
    tolerances: dict[str, tuple[float, Floats]]  # target -> its value, and (machines + 1,) measured
    everywhere: bool = True  # whether it is required of all machines, not only of the nominal one

    def numbers(self) -> Json:
        """Return the results for JSON; None where there is no number."""
        each = self.measured.items()
        bounds, tolerances = (
            {name: {"allowed": most, **_numbers(x[0], x[1:])} for name, (most, x) in limits.items()}
            for limits in (self.bounds, self.tolerances)
        )
        return {
            "share": float(self.good.mean()),
            "reasons": self.reasons,
            "nominal": list(self.nominal_reasons),
            "asked_of": "all" if self.everywhere else "nominal",
            "measures": {name: _numbers(self.nominal[name], column) for name, column in each},
            "constraints": bounds,
            "tolerances": tolerances,
        }


def _numbers(nominal: float, values: Floats) -> Json:
    finite = values[np.isfinite(values)]
    quantiles = np.quantile(finite, [0.5, 0.95, 1.0]).tolist() if len(finite) else [None] * 3
    names = ("nominal", "median", "q95", "largest")
    return dict(zip(names, (storable(nominal), *quantiles), strict=True))


class Stressed(NamedTuple):
    """Result of one stress on some machines, in all motions."""

    name: str  # in words, with its whole size
    holds: bool  # whether the design withstands it
    share: float  # stable under it, of the machines that are stable without it
    merit: float  # of the median machine, divided by that without stress; 0: the design fails
    #: Smallest size tried at which the design fails, as a share of the whole size and in words, and
    #: how it fails. Not used if the design withstands the stress.
    part: float = 1.0
    breaks: str = ""
    why: str = ""
    held: str = ""  # the largest smaller size that was tried, in words

    def numbers(self) -> Json:
        """Return all fields for JSON."""
        return storable(self._asdict())


class Usable(NamedTuple):
    """Answer to whether a design can be used, with the results that it is based on."""

    spread: float
    seed: int
    motions: tuple[MotionResult, ...]
    gain: tuple[float, float] | None  # factors on the command with which the nominal one passes
    precision: float  # change of the merit from float32 to float64, as a share
    substeps: float | None  # change with four times the substeps, as a share; None: not allowed
    units: dict[str, str]  # of the metrics
    margins: LoopMargins | None  # None: the loop cannot be linearised
    repeats: Repeats  # of the merit of the nominal machine, in float64
    stress: tuple[Stressed, ...] = ()  # what was tried beside the scenario's machines
    why_not: Json | None = None  # for the answer no: what would give a yes
    required_margins: Mapping[str, float] = NOTHING  # limits of the margins in ``[constraints]``

    def __repr__(self) -> str:
        return line("Usable", self._summary())

    def _repr_html_(self) -> str:
        each = {f"{one.name}: pass": float(one.good.mean()) for one in self.motions}
        return table(self.answer, self._summary() | each)

    def _summary(self) -> dict[str, object]:
        low, high = self.interval
        share = float(self.good.mean())
        basics = {"yes": self.yes, "spread": self.spread, "machines": len(self.good)}
        summary = {**basics, "share": share, "share_from": low, "share_to": high}
        return summary | ({"misses": missed_text(self.missed)} if self.missed else {})

    @property
    def good(self) -> Mask:
        """(machines,) whether each passes every motion: stable, and every constraint met."""
        return np.logical_and.reduce([one.good for one in self._everywhere])

    @property
    def _everywhere(self) -> tuple[MotionResult, ...]:
        """The motions that are required of all machines."""
        return tuple(one for one in self.motions if one.everywhere)

    @property
    def interval(self) -> tuple[float, float]:
        """Confidence interval of the share of passing machines (Clopper and Pearson)."""
        return share_interval(int(self.good.sum()), len(self.good))

    @property
    def yes(self) -> bool:
        """Whether the answer is yes: all conditions are met, those under stress too."""
        return self.verdict == YES

    @property
    def verdict(self) -> str:
        """The answer: ``YES``, ``ON_THIS_MODEL`` (a stress makes the design fail), or ``NO``."""
        if self.short or self._nominal or self.good.mean() < ENOUGH:
            return NO
        return YES if all(one.holds for one in self.stress) else ON_THIS_MODEL

    @property
    def loop_stable(self) -> bool | None:
        """Whether the nominal loop is stable at the lowest and highest speed; None: unknown."""
        return self.margins and self.margins.stable

    @property
    def short(self) -> dict[str, tuple[float | None, str]]:
        """Margins that are too small: the value of each (None without one), and a text."""
        if self.loop_stable is False:
            return {"stable": (None, UNSTABLE)}
        return self.margins.broken(self.required_margins) if self.margins else {}

    @property
    def missed(self) -> Json:
        """Metrics that miss the scenario's own target: by what factor, and in which motion most.

        They are those of the median machine, or of the nominal one in a motion that is required of
        it alone. Metrics that meet their target are left out.
        """
        return missed({one.name: one.numbers() for one in self.motions})

    @property
    def _nominal(self) -> str:
        """Reason why the nominal machine does not pass; "" if it does."""
        bad = [one for one in self.motions if one.nominal_reasons]
        if not bad:
            return ""
        others = f" and fails in {len(bad) - 1} more motions" if len(bad) > 1 else ""
        others = others.removesuffix("s") if len(bad) == 2 else others
        return f"{' and '.join(bad[0].nominal_reasons)} in {bad[0].name}{others}"

    @property
    def answer(self) -> str:
        """One line: yes, only on this model, or no, and why."""
        share, count = float(self.good.mean()), len(self.good)
        passing = f"{100 * share:.4g} % of {count} unseen machines within +-{100 * self.spread:g} %"
        passing += " pass every motion" if len(self.motions) > 1 else " pass"
        passing += " required of them" if len(self._everywhere) < len(self.motions) else ""
        if self.verdict != NO:
            broken = breaking([one.numbers() for one in self.stress])
            broken = broken if self.stress else UNTRIED
            return f"{self.verdict}: {passing}" + (broken and f"; {broken}")
        why = self._nominal and f"the nominal machine {self._nominal}"
        why = why or ", ".join(words for _, words in self.short.values())
        if why:
            return f"no: {why}; {passing}"
        worst = min(self._everywhere, key=lambda one: float(one.good.mean()))
        reason, many = max(worst.reasons.items(), key=lambda item: item[1])
        outcome = f"only {passing}" if share else f"none of {count} unseen machines passes"
        return f"no: {outcome}; {counted(many, reason)} in {worst.name}"

    def tables(self) -> list[Table]:
        """Return tables: what would turn a no into a yes, motions, and stress tests."""
        return tables(self.numbers())

    def numbers(self) -> Json:
        """Return all results for JSON; None where there is no number."""
        low, high = self.interval
        return {
            "usable": self.yes,
            "verdict": self.verdict,
            "answer": self.answer,
            "missed": self.missed,
            "spread": self.spread,
            "machines": len(self.good),
            "seed": self.seed,
            "share": float(self.good.mean()),
            "interval": [low, high],
            "loop_stable": self.loop_stable,
            "margins": self.margins and self.margins.numbers(),
            "gain": self.gain and [*self.gain],
            "precision": storable(self.precision),
            "substeps": storable(self.substeps),
            "merit": storable(float(self.repeats.values[0])),
            "repeats": self.repeats.numbers(),
            "chaotic": self.repeats.chaotic,
            "why_not": self.why_not,
            "stress": [one.numbers() for one in self.stress],
            "units": self.units,
            "motions": {one.name: one.numbers() for one in self.motions},
        }


def merit_text(numbers: Json) -> str:
    """Return a sentence on the merit, from ``Usable.numbers``, if it is chaotic; otherwise ""."""
    return chaos_text("merit", numbers["repeats"]) if numbers.get("chaotic") else ""


def numerics_text(numbers: Json) -> str:
    """Return advice if rounding or time steps change the merit much; otherwise "".

    ``numbers`` are those of ``Usable.numbers``. For a chaotic design there is no such advice.
    """
    ways = {"precision": "--precision float64", "substeps": "four times simulation.substeps"}
    coarse = [f"with {way}" for key, way in ways.items() if (numbers[key] or 0.0) > COARSE]
    if not coarse or numbers.get("chaotic"):
        return ""
    return f"the search computed the merit too coarsely: search again {' and '.join(coarse)}"


def gain_text(gain: tuple[float, float]) -> str:
    """Return a text on the factors on the command between which a machine passes."""
    low, high = (f"{factor:.3g}" for factor in gain)
    low = f"at most {low}" if gain[0] <= SMALLEST_TRIED * (1.0 + 1e-9) else low
    high = f"at least {high}" if gain[1] >= LARGEST_TRIED * (1.0 - 1e-9) else high
    return f"with the command multiplied by {low} to {high}"


def missed(motions: Json) -> Json:
    """Return metrics beyond their target: ``times`` the target in the ``motion`` where it is most.

    ``motions`` are those of ``Usable.numbers``. The metrics are those of the median machine, or of
    the nominal machine in a motion that is required of it alone.
    """
    misses: Json = {}
    for motion, one in motions.items():
        which = "nominal" if one["asked_of"] == "nominal" else "median"
        for name, row in one["tolerances"].items():
            times = (row[which] or 0.0) / row["allowed"]  # None: no finite value, the answer is no
            if times > misses.get(name, {"times": 1.0 + SAME_SINGLE})["times"]:
                misses[name] = {"times": times, "motion": motion}
    return misses


def missed_text(misses: Json, motions: int = 2) -> str:
    """Return a line on the missed metrics, "" if there are none; a single motion is not named."""
    targets = [
        f"{name} {three_digits(one['times'])}" + (f" ({one['motion']})" if motions > 1 else "")
        for name, one in misses.items()
    ]
    worst = " in the worst motion" if motions > 1 else ""
    line = f"targets missed, value divided by target{worst}: {', '.join(targets)}"
    return line if targets else ""


def measured_loop(
    design: Design, scenario: Scenario, later: float | None = None
) -> tuple[Loop, Gains]:
    """Return a design's loop (see ``closed_loop``) and gains, with the metrics of ``_measured``."""
    controller, gains = controller_of(design, scenario)
    loop = closed_loop(scenario, controller, later)
    measures = _once(_measured(scenario))
    return loop._replace(judge=loop.judge._replace(measured=(*measures.values(),))), gains


def _measured(scenario: Scenario) -> list[list[Constraint]]:
    """Return targets, constraints, reported metrics and ``STABILITY``, a list each."""
    bounds = list(constraints_on(scenario.constraints, scenario.units))
    free = ([Constraint(one, np.inf) for one in some] for some in (_reported(scenario), STABILITY))
    return [_tolerances(scenario), bounds, *free]


def _once(groups: list[list[Constraint]]) -> dict[str, Metric]:
    """Return each metric once, by its name, in the order of the values: ``STABILITY`` comes last.

    So a bound on a metric that is measured anyway needs no compiled program of its own.
    """
    each = [one.metric for group in groups for one in group]
    return dict(reversed({one.name: one for one in reversed(each)}.items()))


def _values(scenario: Scenario, judged: Judged) -> list[dict[str, tuple[Constraint, Floats]]]:
    """Return for each list of ``_measured``: name -> bound, and values (individuals, motions)."""
    values, groups = np.asarray(judged.values), _measured(scenario)
    names = _once(groups)
    columns = dict(zip(names, np.moveaxis(values[..., -len(names) :], -1, 0), strict=True))
    return [{one.metric.name: (one, columns[one.metric.name]) for one in group} for group in groups]


def units(scenario: Scenario) -> dict[str, str]:
    """Return the unit in which each reported metric is shown, by the name of the metric."""
    return {one.name: _unit(one, scenario) for one in _reported(scenario)}


def _reported(scenario: Scenario) -> tuple[Metric, ...]:
    tracking = "estimated_rms_contour_error" if scenario.follows_path else "settled_rms_error"
    return tuple(RUNNING[name] for name in (tracking, "chatter", "peak_command"))


def _unit(one: Metric, scenario: Scenario) -> str:
    return scenario.units.signals.get(one.unit, one.unit)


def broken_by(scenario: Scenario, judged: Judged) -> dict[str, Mask]:
    """Return: reason not to pass -> (machines, motions) where it applies, the nominal one first."""
    failed = np.asarray(judged.failed)
    violations = instabilities(np.asarray(judged.values), failed, scenario.each_motion())
    for name, (bound, values) in bounds_of(scenario, judged).items():
        violations[f"exceeds {name}"] = ~(values <= bound.most * (1.0 + SAME_SINGLE)) & ~failed
    return violations


def bounds_of(scenario: Scenario, judged: Judged) -> dict[str, tuple[Constraint, Floats]]:
    """Return: name of a constraint -> the constraint, and measured values (machines, motions)."""
    return _values(scenario, judged)[1]


def _tolerances(scenario: Scenario) -> list[Constraint]:
    """Return the metrics with a target in the fitness; none if the fitness has no targets."""
    fitness = scenario.fitness.on(scenario.units)
    if not isinstance(fitness, TolerancesSettings):
        return []
    return [Constraint(one, most) for one, most, _ in tolerated(fitness)]


def tolerated_metrics(scenario: Scenario) -> dict[str, tuple[Metric, str]]:
    """Return the metrics with a target in the fitness, with meanings, by the keys of tables."""
    metrics = {}
    for one, _ in _tolerances(scenario):
        unit = " ".join(scenario.units.signals.get(word, word) for word in one.unit.split(" "))
        key = one.name if unit == "1" else f"{one.name}_{in_a_name(unit)}"
        metrics[key] = one, f"{one.meaning} [{unit}]"
    return metrics


def motion_result(scenario: Scenario, judged: Judged, k: int, motion: Scenario) -> MotionResult:
    """Return the results of machines in motion ``k``; in ``judged`` the nominal one is first."""
    reasons = {why: mask[:, k] for why, mask in broken_by(scenario, judged).items()}
    tolerances, bounds, measures, last = (
        {name: (constraint.most, values[:, k]) for name, (constraint, values) in part.items()}
        for part in _values(scenario, judged)
    )
    over = {}
    for name, (bound, _) in bounds_of(scenario, judged).items():
        most, values = bounds[name]
        unit = _unit(bound.metric, scenario)
        over[f"exceeds {name}"] = f" ({values[0]:.3g} {unit}, allowed {most:.3g})"
    bad = np.logical_or.reduce([*reasons.values()])
    why_not = [why + over.get(why, "") for why, mask in reasons.items() if mask[0]]
    if (steps := motion.simulation.steps) < LEAST_SAMPLES:
        needed = f"{steps} samples, at least {LEAST_SAMPLES} are needed"
        why_not.append(f"cannot be judged to settle ({needed})")
    measures["limit_share"] = last["limit_share"]
    return MotionResult(
        motion.name.rpartition(".")[2] if scenario.motions else motion.name,
        ~bad[1:],
        {why: int(mask[1:].sum()) for why, mask in reasons.items() if mask[1:].any()},
        {name: column[1:] for name, (_, column) in measures.items()},
        {name: float(column[0]) for name, (_, column) in measures.items()},
        tuple(why_not),
        bounds,
        tolerances,
        not scenario.nominal_only[k],
    )
