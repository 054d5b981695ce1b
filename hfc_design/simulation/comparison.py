"""Comparison of designs: every design in every motion on every machine, then pair by pair.

A machine on which the loop of a design is not stable is not left out: there the design loses
against every design that is stable, whatever its numbers.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Json, Mask, storable
from hfc_design.core.records import UserError
from hfc_design.core.statistics import Interval, holm, paired, share_interval
from hfc_design.core.tables import line, table
from hfc_design.core.validation_errors import short
from hfc_design.core.wording import one_of
from hfc_design.files.design import Design
from hfc_design.files.design_set import (
    AnyDesigns,
    differences,
    labelled,
    own_machine,
    shared_machine,
)
from hfc_design.files.loop_setup import own_scenario
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.plausibility import plausibility_warnings
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.acceptance import tolerated_metrics
from hfc_design.simulation.evaluating import table_of
from hfc_design.simulation.machines import NONE
from hfc_design.simulation.monte_carlo import Robustness, check_draw, robustness
from hfc_design.simulation.repeats import chaos_text
from hfc_design.simulation.stability_criteria import reasons_text

#: Rank of a metric that is compared only because the scenario has a target for it.
LAST = 99
#: Quantities of which more is better; of every metric less is better.
SCORES = ("fitness", "merit")
#: Name of all motions together.
EVERY = "every motion"
#: Shares of the machines for the two quantiles in ``numbers``: half of them, nearly all.
HALF, NEARLY_ALL = 0.5, 0.95
#: Spread of the machines for scenarios without ``[robust]``.
SPREAD = 0.2
Progress = Callable[[str, int, int], None]


class DesignStatistics(NamedTuple):
    """Results of one design in one motion, or in all motions, on the nominal and other machines."""

    stable: Mask  # (machines,)
    nominal_stable: bool
    nominal: dict[str, float]  # metric -> value on the nominal machine; nan: none
    values: dict[str, Floats]  # metric -> values on the other machines, (machines,)
    ranges: dict[str, Json] = {}  # of the nominal machine's scores that are chaotic

    def numbers(self) -> Json:
        """Return the statistics for JSON; None where there is no number."""
        metrics = {}
        for key in self.values:
            median, most = self.quantile(key, HALF), self.quantile(key, NEARLY_ALL)
            numbers = {"nominal": self.of_nominal(key), "median": median, "95_percent": most}
            metrics[key] = numbers
        return {
            "stable_share": float(self.stable.mean()),
            "stable_interval": list(self.interval),
            "nominal_stable": bool(self.nominal_stable),
            "repeats": self.ranges,
            "metrics": metrics,
        }

    @property
    def interval(self) -> Interval:
        """Confidence interval of the share of stable machines."""
        return share_interval(int(self.stable.sum()), len(self.stable))

    def costs(self, key: str) -> Floats:
        """Return costs (machines,) by a metric, less is better; inf: not stable, or no number."""
        costs = -self.values[key] if key in SCORES else np.abs(self.values[key])
        return np.where(self.stable & np.isfinite(costs), costs, np.inf)

    def quantile(self, key: str, share: float) -> float | None:
        """Return the value that a ``share`` of all machines reaches or betters; None: fewer do."""
        cost = float(np.quantile(self.costs(key), share, method="inverted_cdf"))
        return None if cost == np.inf else (-cost if key in SCORES else cost)

    def span(self, key: str) -> tuple[float | None, float | None, float | None]:
        """Return the values of a metric that 5 %, 50 % and 95 % of the machines reach or better."""
        return self.quantile(key, 0.05), self.quantile(key, 0.5), self.quantile(key, 0.95)

    def of_nominal(self, key: str) -> float | None:
        """Return the metric of the nominal machine, lowest repeat if chaotic; None: it has none.

        Errors are magnitudes, as in ``costs``: signed errors cannot be ranked.
        """
        if key in self.ranges:
            return None if self.ranges[key]["lowest"] is None else float(self.ranges[key]["lowest"])
        metric = self.nominal[key] if key in SCORES else abs(self.nominal[key])
        return metric if self.nominal_stable and np.isfinite(metric) else None


class MotionComparison(NamedTuple):
    """The designs in one motion."""

    name: str
    scenario: Scenario | None  # of that motion alone; None for all motions together
    sides: dict[str, DesignStatistics]  # by the designs' names
    results: dict[str, Robustness]  # by the designs' names; empty for all motions together
    meanings: dict[str, str]  # of each metric, with its unit

    def compared(self) -> list[str]:
        """Return the metrics that are compared, the most important first."""
        if self.scenario is None:  # all motions together have one metric, which is compared
            return list(self.meanings)
        tolerated = tolerated_metrics(self.scenario).items()
        ranks = {key: one.rank or LAST for key, (one, _) in tolerated}
        ranks |= {key: one.rank for key, one in table_of(self.scenario).items()}
        compared = [key for key in self.meanings if ranks.get(key)]
        return sorted(compared, key=lambda key: ranks[key])

    def lost(self) -> Iterator[str]:
        """Yield a line for each design that does not keep all machines stable, with the reasons."""
        for name, one in self.results.items():
            reasons = []
            if not one.nominal_stable:
                reasons.append(f"nominal machine {' and '.join(one.nominal_reasons)}")
            if one.reasons:
                reasons.append(f"of {len(one.stable)} others {reasons_text(one.reasons)}")
            if reasons:
                yield f"{name} in {self.name}, not stable: {'; '.join(reasons)}"

    def chaos(self) -> Iterator[str]:
        """Yield a line for each score that is chaotic on the nominal machine."""
        for name, side in self.sides.items():
            for key, repeats in side.ranges.items():
                if key in self.meanings:
                    yield f"{name} in {self.name}: {chaos_text(key, repeats)}"


class Difference(NamedTuple):
    """Difference of two designs by one metric, paired machine by machine."""

    motion: str
    metric: str
    first: str
    second: str
    both: int  # machines that both designs keep stable; then: only the first, the second, neither
    only_first: int
    only_second: int
    neither: int
    better: int  # machines on which the first is better, by its number or by being stable at all
    worse: int
    better_interval: Interval  # of the share of ``better`` in all machines
    ratio: float  # median of cost ratios first / second; 0 where only the first is stable
    ratio_interval: Interval | None
    p: float  # of a two-sided test of the pairs
    p_holm: float  # after Holm's correction for every difference of the comparison

    @property
    def machines(self) -> int:
        """Number of all machines."""
        return self.both + self.only_first + self.only_second + self.neither

    def numbers(self) -> Json:
        """Return all fields for JSON; None where there is no number."""
        return storable(self._asdict())


def spread_text(spread: float, tolerances: Mapping[str, float]) -> str:
    """Return the spread of the machines about the nominal one, in words."""
    single = (f", {name} ±{100 * tolerance:g} %" for name, tolerance in tolerances.items())
    return f"±{100 * spread:g} %{''.join(single)}"


class Comparison(NamedTuple):
    """Result of a comparison of designs."""

    designs: dict[str, Design]
    spread: float
    seed: int
    machines: int
    bouts: list[MotionComparison]  # one a motion; of several motions also one of all together
    differences: list[Difference]
    notes: list[str]  # remarks, for example on conditions that differ between the designs
    tolerances: dict[str, float] = {}  # spreads of single parameters

    def __repr__(self) -> str:
        return line("Comparison", self._summary())

    def _repr_html_(self) -> str:
        return table("Comparison", self._summary())

    def _summary(self) -> dict[str, object]:
        bouts = [bout.name for bout in self.bouts]
        summary = {"designs": ", ".join(self.designs), "motions": ", ".join(bouts)}
        return {**summary, "machines": self.machines, "within": self.within}

    @property
    def within(self) -> str:
        """The spread of the machines about the nominal one, in words."""
        return spread_text(self.spread, self.tolerances)

    def of(self, motion: str, metric: str) -> list[Difference]:
        """Return the differences by a metric in a motion.

        Raises:
            UserError: there is no such motion, or it has no such metric, or the metric is in tables
                but not compared: each further comparison makes differences harder to show.
        """
        bouts = {bout.name: bout for bout in self.bouts}
        if motion not in bouts:
            raise UserError(f"motion {short(motion)}: unknown motion; {one_of(motion, bouts)}")
        if metric not in (known := bouts[motion].meanings):
            unknown = f"unknown metric of {motion}; {one_of(metric, known)}"
            raise UserError(f"metric {short(metric)}: {unknown}")
        if metric not in (compared := bouts[motion].compared()):
            reason = "is in the tables, but its differences are not tested; tested are"
            raise UserError(f"metric {short(metric)}: {reason} {', '.join(compared)}")
        return [x for x in self.differences if (x.motion, x.metric) == (motion, metric)]

    def numbers(self) -> Json:
        """Return the contents of all tables for JSON; None where there is no number."""
        motions = {}
        for bout in self.bouts:
            sides = {name: side.numbers() for name, side in bout.sides.items()}
            motions[bout.name] = {"meanings": bout.meanings, "designs": sides}
        return {
            "designs": list(self.designs),
            "spread": self.spread,
            "tolerances": self.tolerances,
            "seed": self.seed,
            "machines": self.machines,
            "notes": self.notes,
            "motions": motions,
            "differences": [one.numbers() for one in self.differences],
        }


def compare(
    designs: AnyDesigns,
    scenarios: AnyScenario | Sequence[AnyScenario] = (),
    spread: float | None = None,
    machines: int = 200,
    seed: int = 0,
    progress: Progress = lambda what, done, total: None,
    tolerances: Mapping[str, float] = NONE,
) -> Comparison:
    """Simulate every design in every motion, on the nominal machine and on others.

    The nominal machine is that of the first design, as changed by each scenario; the others are
    drawn from its tolerances, and are the same for all designs. The tables mark the best of each
    row, and compare the first design with every other machine by machine: median ratio and its
    interval, on how many machines it is better, and p of Wilcoxon's signed-rank test, corrected by
    Holm over all comparisons. A design loses on a machine that it does not keep stable.

    Args:
        designs: designs, or a mapping of names to designs.
        scenarios: scenarios to compare in; default: that of the first design.
        spread: relative spread of each physical parameter; default: that of ``[robust]`` of the
            first scenario that has it, with its tolerances, else 0.2.
        machines: number of perturbed machines.
        seed: random seed of the machines.
        progress: function called with what, done and total after every chunk of machines.
        tolerances: relative spread of one parameter instead of ``spread``, as in backlash=0.5.

    Raises:
        UserError: there are fewer than two designs, one is given twice or cannot run, or a number
            is not allowed.
    """
    named = labelled(designs)
    if len(named) < 2:
        raise UserError("needs at least two designs, as in hfc compare runs/mine pd-only")
    loaded_scenarios = _scenarios(designs, named, scenarios)
    if spread is None:
        robust = next((one.robust for one in loaded_scenarios if one.robust), None)
        spread, known = (robust.spread, robust.tolerances) if robust else (SPREAD, {})
        tolerances = {**known, **tolerances}
    check_draw(spread, machines, seed, tolerances, "machines")
    where: list[tuple[Scenario, bool]] = []  # motions; whether each is required of all machines
    notes: dict[str, list[str]] = {}  # note -> designs that it is about
    others: list[str] = []
    for scenario in loaded_scenarios:
        others += _other_machines(scenario, spread, tolerances)
        shared = shared_machine(named, scenario)
        told_of = [own_machine(next(iter(named)), scenario, shared), *plausibility_warnings(shared)]
        others += [f"{scenario.name}: {warning}" for warning in told_of if warning]
        where += zip(shared.each_motion(), (not one for one in shared.nominal_only), strict=True)
        for name, design in named.items():
            for note in differences(design, scenario, shared):
                members = notes.setdefault(note, [])
                members += [name] * (name not in members)
    names = [motion.name for motion, _ in where]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UserError(f"scenarios must have different names (got {twice} twice)")
    total = len(named) * len(where) * (machines + 1)
    bouts: list[MotionComparison] = []
    for k, (motion, _) in enumerate(where):
        start = k * len(named) * (machines + 1)

        def heard(what: str, done: int, start: int = start) -> None:
            progress(what, start + done, total)

        bouts.append(_bout(named, motion, (spread, machines, seed), tolerances, heard))
    bouts += _together([bout for bout, (_, every) in zip(bouts, where, strict=True) if every])
    said = [*dict.fromkeys(others), *(f"{', '.join(who)}: {note}" for note, who in notes.items())]
    said += [text for bout in bouts for text in (*bout.lost(), *bout.chaos())]
    results = bouts, _differences(bouts), said
    return Comparison(named, spread, seed, machines, *results, dict(tolerances))


def _bout(
    named: dict[str, Design],
    motion: Scenario,
    draw: tuple[float, int, int],
    tolerances: Mapping[str, float],
    progress: Callable[[str, int], None],
) -> MotionComparison:
    """Compare the designs in one motion, on the machines of a ``draw``: spread, count, seed."""
    _, machines, _ = draw
    results: dict[str, Robustness] = {}
    for k, (name, design) in enumerate(named.items()):

        def more(chunk: int, _: int, name: str = name, done: int = k * (machines + 1)) -> None:
            progress(f"{name} in {motion.name}", done + min(chunk, machines))

        results[name] = robustness(design, motion, *draw, more, tolerances)
    copied = attrgetter(*DesignStatistics._fields)
    sides = {name: DesignStatistics(*copied(one)) for name, one in results.items()}
    meanings = next(iter(results.values())).meanings
    return MotionComparison(motion.name, motion, sides, results, meanings)


def _scenarios(
    designs: AnyDesigns, named: dict[str, Design], scenarios: AnyScenario | Sequence[AnyScenario]
) -> list[Scenario]:
    several = isinstance(scenarios, Sequence) and not isinstance(scenarios, str)
    given: Any = scenarios if several else [scenarios]
    if len(given):
        return [load_scenario(one) for one in given]
    source: Any = next(iter(designs.values() if hasattr(designs, "values") else designs))
    design = next(iter(named.values()))
    return [own_scenario(design, design.name if source is design else str(source))]


def _other_machines(
    scenario: Scenario, spread: float, tolerances: Mapping[str, float]
) -> Iterator[str]:
    """Yield a note if a scenario has other machines in ``[robust]``, which are not used here."""
    robust = scenario.robust
    if robust is None or (robust.spread, robust.tolerances) == (spread, dict(tolerances)):
        return
    text = spread_text(robust.spread, robust.tolerances)
    yield f"machines differ from [robust] of {scenario.name}, which has {text}"


def _together(bouts: Sequence[MotionComparison]) -> list[MotionComparison]:
    """Return all motions as one comparison: stable in all motions, errors over all samples.

    The list is empty if there is only one motion, or if motions differ in machines or metrics.
    """
    nominal_parameters = [next(iter(bout.results.values())).machines.nominal for bout in bouts]
    key = bouts[0].compared()[0]
    alike = len({*nominal_parameters}) == 1 and all(key in bout.meanings for bout in bouts)
    if len(bouts) < 2 or not alike:
        return []
    steps = [bout.scenario.simulation.steps for bout in bouts if bout.scenario]
    sides = {}
    for name in bouts[0].sides:
        each = [bout.sides[name] for bout in bouts]
        nominal = float(_rms([side.nominal[key] for side in each], steps))
        values = _rms([side.values[key] for side in each], steps)
        stable = np.logical_and.reduce([side.stable for side in each])
        all_nominal = all(side.nominal_stable for side in each)
        sides[name] = DesignStatistics(stable, all_nominal, {key: nominal}, {key: values})
    return [MotionComparison(EVERY, None, sides, {}, {key: bouts[0].meanings[key]})]


def _rms(each: Any, steps: Sequence[int]) -> Any:
    """Return the root mean square over several motions, from that of each and its ``steps``."""
    with np.errstate(over="ignore"):
        return np.sqrt(np.average(np.square(each), axis=0, weights=steps))


def _differences(bouts: Sequence[MotionComparison]) -> list[Difference]:
    """Return the differences of every two designs by every metric in every motion."""
    comparisons = [
        _difference(bout, key, first, second)
        for bout in bouts
        for key in bout.compared()
        for first, second in combinations(bout.sides, 2)
    ]
    corrected = holm(np.array([one.p for one in comparisons]))
    return [one._replace(p_holm=float(p)) for one, p in zip(comparisons, corrected, strict=True)]


def _difference(bout: MotionComparison, key: str, first: str, second: str) -> Difference:
    one, other = bout.sides[first], bout.sides[second]
    mine, theirs, a, b = one.stable, other.stable, one.costs(key), other.costs(key)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Equal are two costs without a number (inf), and two that differ only by rounding.
        both = np.where((a == b) | np.isclose(a, b, SAME, 0.0), 0.0, np.log(a) - np.log(b))
    alone = np.where(mine, -np.inf, np.inf)
    logarithms = np.where(mine & theirs, both, alone)[mine | theirs]
    apart = (mine & theirs, mine & ~theirs, ~mine & theirs, ~mine & ~theirs)
    in_both, first_only, second_only, neither = (int(mask.sum()) for mask in apart)
    better, worse = int((logarithms < 0).sum()), int((logarithms > 0).sum())
    share, tested = share_interval(better, len(a)), paired(logarithms)
    stable = (in_both, first_only, second_only, neither)
    pair = (bout.name, key, first, second)
    return Difference(*pair, *stable, better, worse, share, *tested, p_holm=tested.p)
