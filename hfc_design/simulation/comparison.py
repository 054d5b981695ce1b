"""Designs side by side: the same motions, the same machines, differences machine by machine.

A design that does not hold a machine is not left out there: it has lost against every one that
does, whatever its numbers. ``core.statistics`` has the tests.
"""

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.core.records import UserError
from hfc_design.core.statistics import Interval, holm, paired, share_interval
from hfc_design.files.design import Design
from hfc_design.files.pairing import own_scenario
from hfc_design.files.scenario import AnyScenario, Scenario, load_scenario
from hfc_design.files.together import AnyDesigns, differences, labelled, on_one_machine
from hfc_design.simulation.evaluation import meanings
from hfc_design.simulation.monte_carlo import MAX_SAMPLES, Robustness, robustness

#: Parts of the names of the metrics that are compared, in the order of every table.
COMPARED = (
    *("rms_contour_error", "max_contour_error", "worst_glitch", "rms_error", "max_error"),
    *("settling_time", "_change", "peak_", "stick_share"),
)
#: Of these more is better, of every metric less.
SCORES = ("fitness", "merit")
#: What stands for all motions together.
EVERY = "every motion"
Progress = Callable[[str, int, int], None]


class Side(NamedTuple):
    """One design in one motion, or in all: the nominal machine and every other."""

    stable: Mask  # (machines,)
    nominal_stable: bool
    nominal: dict[str, float]  # of each metric; nan where there is none
    values: dict[str, Floats]  # the same, (machines,)

    @property
    def interval(self) -> Interval:
        """Where the share of stable machines lies among all that there could be."""
        return share_interval(int(self.stable.sum()), len(self.stable))

    def costs(self, key: str) -> Floats:
        """(machines,) by a metric, less is better; infinite without a number or if not stable."""
        found = -self.values[key] if key in SCORES else np.abs(self.values[key])
        return np.where(self.stable & np.isfinite(found), found, np.inf)

    def quantile(self, key: str, share: float) -> float | None:
        """The metric that a ``share`` of all machines does as well as; None: it has none."""
        found = float(np.quantile(self.costs(key), share, method="inverted_cdf"))
        return None if found == np.inf else (-found if key in SCORES else found)

    def of_nominal(self, key: str) -> float | None:
        """The metric of the nominal machine; None: it has none."""
        found = self.nominal[key]
        return found if self.nominal_stable and np.isfinite(found) else None


class Bout(NamedTuple):
    """The designs in one motion."""

    name: str
    scenario: Scenario | None  # of that motion alone; None of all motions together
    sides: dict[str, Side]  # by the designs' names
    found: dict[str, Robustness]  # empty of all motions together
    meanings: dict[str, str]  # of each metric, with its unit

    def compared(self) -> list[str]:
        """The metrics that are compared, the most important first."""
        windows = () if self.scenario is None else self.scenario.windows
        heads = tuple(f"{window.name}_" for window in windows)
        keys = [key for key in self.meanings if not key.startswith(heads)]
        return [key for part in COMPARED for key in keys if part in key]


class Difference(NamedTuple):
    """Two designs by one metric, paired machine by machine."""

    motion: str
    metric: str
    first: str
    second: str
    both: int  # machines that both keep stable; only the first, only the second, neither
    only_first: int
    only_second: int
    neither: int
    better: int  # machines on which the first is better, by its number or by being stable at all
    worse: int
    better_interval: Interval  # of the share of ``better`` in all machines
    ratio: float  # median of first over second where one is stable; 0: only the first
    ratio_interval: Interval | None
    p: float  # two-sided, of the same machines
    p_holm: float  # after Holm's correction for every difference of the comparison

    @property
    def machines(self) -> int:
        """All of them."""
        return self.both + self.only_first + self.only_second + self.neither


class Comparison(NamedTuple):
    """What designs do side by side."""

    designs: dict[str, Design]
    spread: float
    seed: int
    machines: int
    bouts: list[Bout]  # one a motion, and if there are several one of all
    differences: list[Difference]
    notes: list[str]  # what is not alike

    def of(self, motion: str, metric: str) -> list[Difference]:
        """The differences by a metric in a motion."""
        return [x for x in self.differences if (x.motion, x.metric) == (motion, metric)]


def compare(
    designs: AnyDesigns,
    scenarios: AnyScenario | Sequence[AnyScenario] = (),
    spread: float = 0.2,
    machines: int = 200,
    seed: int = 0,
    progress: Progress = lambda what, done, total: None,
) -> Comparison:
    """Simulate every design in every motion, on the nominal machine and on ``machines`` others.

    The machine is that of the first design with what each scenario sets laid over it, and each
    one that ``monte_carlo.drawn`` draws meets all designs. Without ``scenarios`` it is the one that
    the first design was made for. ``progress(what, done, total)`` hears of every chunk of machines.

    Raises:
        UserError: there are not two designs, one stands there twice, or cannot run in a scenario.
    """
    named = labelled(designs)
    if len(named) < 2:
        raise UserError("needs two designs at least, as in hfc compare runs/mine pd-only")
    if not 1 <= machines <= MAX_SAMPLES:
        raise UserError(f"--machines {machines}: has to lie between 1 and {MAX_SAMPLES}")
    where: list[Scenario] = []
    notes: dict[str, None] = {}
    for scenario in _scenarios(designs, named, scenarios):
        shared = on_one_machine(named, scenario)
        where += shared.each_motion()
        for name, design in named.items():
            notes |= {f"{name} {note}": None for note in differences(design, scenario, shared)}
    names = [motion.name for motion in where]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UserError(f"scenario {twice}: two of them have this name")
    bouts: list[Bout] = []
    done, total = 0, len(named) * len(where) * (machines + 1)
    for motion in where:
        found: dict[str, Robustness] = {}
        for name, design in named.items():

            def more(chunk: int, _: int, what: str = f"{name} in {motion.name}") -> None:
                progress(what, done + min(chunk, machines), total)  # noqa: B023 - called at once

            found[name] = robustness(design, motion, spread, machines, seed, more)
            done += machines + 1
        sides = {name: _side(x) for name, x in found.items()}
        told = {**motion.judge().titles, **meanings(motion)}
        bouts.append(Bout(motion.name, motion, sides, found, told))
    bouts += _together(bouts)
    return Comparison(named, spread, seed, machines, bouts, _differences(bouts), [*notes])


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


def _side(found: Robustness) -> Side:
    return Side(found.stable, found.nominal_stable, found.nominal, found.values)


def _together(bouts: Sequence[Bout]) -> list[Bout]:
    """All motions as one: stable in every one, errors as of one motion after the other.

    Nothing if there is but one, or if their machines or metrics are not the same.
    """
    told = [next(iter(bout.found.values())).machines.told for bout in bouts]
    key = bouts[0].compared()[0]
    if len(bouts) < 2 or any(key not in bout.meanings for bout in bouts) or len({*told}) > 1:
        return []
    steps = [bout.scenario.simulation.steps for bout in bouts if bout.scenario]
    sides = {}
    for name in bouts[0].sides:
        each = [bout.sides[name] for bout in bouts]
        nominal = float(_rms([side.nominal[key] for side in each], steps))
        values = _rms([side.values[key] for side in each], steps)
        stable = np.logical_and.reduce([side.stable for side in each])
        all_nominal = all(side.nominal_stable for side in each)
        sides[name] = Side(stable, all_nominal, {key: nominal}, {key: values})
    return [Bout(EVERY, None, sides, {}, {key: bouts[0].meanings[key]})]


def _rms(each: Any, steps: Sequence[int]) -> Any:
    """Root mean square over all samples of motions of so many ``steps``, of that of each."""
    with np.errstate(over="ignore"):
        return np.sqrt(np.average(np.square(each), axis=0, weights=steps))


def _differences(bouts: Sequence[Bout]) -> list[Difference]:
    """Every two designs by every metric in every motion."""
    found = [
        _difference(bout, key, first, second)
        for bout in bouts
        for key in bout.compared()
        for first, second in combinations(bout.sides, 2)
    ]
    corrected = holm(np.array([one.p for one in found]))
    return [one._replace(p_holm=float(p)) for one, p in zip(found, corrected, strict=True)]


def _difference(bout: Bout, key: str, first: str, second: str) -> Difference:
    one, other = bout.sides[first], bout.sides[second]
    a, b = one.costs(key), other.costs(key)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Two without a number, that never settle say, are equal.
        both = np.where(a == b, 0.0, np.log(a) - np.log(b))
    alone = np.where(one.stable, -np.inf, np.inf)
    logarithms = np.where(one.stable & other.stable, both, alone)[one.stable | other.stable]
    stable = (
        int((one.stable & other.stable).sum()),
        int((one.stable & ~other.stable).sum()),
        int((~one.stable & other.stable).sum()),
        int((~one.stable & ~other.stable).sum()),
    )
    better, worse = int((logarithms < 0).sum()), int((logarithms > 0).sum())
    share, tested = share_interval(better, len(a)), paired(logarithms)
    pair = (bout.name, key, first, second)
    return Difference(*pair, *stable, better, worse, share, *tested, p_holm=tested.p)
