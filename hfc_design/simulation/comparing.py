"""Designs are put side by side: everybody in every motion on every machine, then pair by pair."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from hfc_design.core.numbers import SAME
from hfc_design.core.records import UserError
from hfc_design.core.statistics import holm, paired, share_interval
from hfc_design.files.design import Design
from hfc_design.files.doubts import doubts
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import own_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.files.together import AnyDesigns, differences, labelled, on_one_machine, own_machine
from hfc_design.simulation.comparison import Bout, Comparison, Difference, Side, spread_told
from hfc_design.simulation.machines import NONE
from hfc_design.simulation.monte_carlo import Robustness, check_draw, robustness

#: Of a scenario that says nothing about tolerances.
SPREAD = 0.2
#: What stands for all motions together.
EVERY = "every motion"
Progress = Callable[[str, int, int], None]


def compare(
    designs: AnyDesigns,
    scenarios: AnyScenario | Sequence[AnyScenario] = (),
    spread: float | None = None,
    machines: int = 200,
    seed: int = 0,
    progress: Progress = lambda what, done, total: None,
    tolerances: Mapping[str, float] = NONE,
) -> Comparison:
    """Simulate every design in every motion, on the nominal machine and on ``machines`` others.

    The machine is that of the first design with what each scenario sets laid over it, and each
    one that ``machines.drawn`` draws meets all designs; ``tolerances`` are the spreads of single
    parameters, laid over those of ``[robust]`` of the first scenario that has it, whose spread is
    taken too where none is given (else ``SPREAD``). Without ``scenarios`` it is the one that the
    first design was made for. ``progress(what, done, total)`` hears of every chunk of machines.

    Raises:
        UserError: there are not two designs, one stands there twice, or cannot run in a scenario;
            or a number is not allowed.
    """
    named = labelled(designs)
    if len(named) < 2:
        raise UserError("needs two designs at least, as in hfc compare runs/mine pd-only")
    asked = _scenarios(designs, named, scenarios)
    if spread is None:
        own = next((one.robust for one in asked if one.robust), None)
        spread, known = (own.spread, own.tolerances) if own else (SPREAD, {})
        tolerances = {**known, **tolerances}
    check_draw(spread, machines, seed, tolerances, "--machines")
    where: list[tuple[Scenario, bool]] = []  # motions, and whether all machines are asked
    notes: dict[str, list[str]] = {}  # of which designs each is
    others: list[str] = []
    for scenario in asked:
        others += _other_machines(scenario, spread, tolerances)
        shared = on_one_machine(named, scenario)
        told_of = [own_machine(next(iter(named)), scenario, shared), *doubts(shared)]
        others += [f"{scenario.name}: {told}" for told in told_of if told]
        where += zip(shared.each_motion(), (not one for one in shared.nominal_only), strict=True)
        for name, design in named.items():
            for note in differences(design, scenario, shared):
                members = notes.setdefault(note, [])
                members += [name] * (name not in members)
    names = [motion.name for motion, _ in where]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UserError(f"scenario {twice}: two of them have this name")
    total = len(named) * len(where) * (machines + 1)
    bouts: list[Bout] = []
    for k, (motion, _) in enumerate(where):
        start = k * len(named) * (machines + 1)

        def heard(what: str, done: int, start: int = start) -> None:
            progress(what, start + done, total)

        bouts.append(_bout(named, motion, (spread, machines, seed), tolerances, heard))
    bouts += _together([bout for bout, (_, every) in zip(bouts, where, strict=True) if every])
    said = [*dict.fromkeys(others), *(f"{', '.join(who)}: {note}" for note, who in notes.items())]
    said += [told for bout in bouts for told in (*bout.lost(), *bout.chaos())]
    found = bouts, _differences(bouts), said
    return Comparison(named, spread, seed, machines, *found, dict(tolerances))


def _bout(
    named: dict[str, Design],
    motion: Scenario,
    draw: tuple[float, int, int],
    tolerances: Mapping[str, float],
    progress: Callable[[str, int], None],
) -> Bout:
    """Every design in one motion, on the machines of a ``draw``: spread, count, seed."""
    _, machines, _ = draw
    found: dict[str, Robustness] = {}
    for k, (name, design) in enumerate(named.items()):

        def more(chunk: int, _: int, name: str = name, done: int = k * (machines + 1)) -> None:
            progress(f"{name} in {motion.name}", done + min(chunk, machines))

        found[name] = robustness(design, motion, *draw, more, tolerances)
    sides = {name: _side(x) for name, x in found.items()}
    return Bout(motion.name, motion, sides, found, next(iter(found.values())).meanings)


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
    """That a scenario has machines of its own, which these are not."""
    own = scenario.robust
    if own is None or (own.spread, own.tolerances) == (spread, dict(tolerances)):
        return
    told = spread_told(own.spread, own.tolerances)
    yield f"other machines than those of [robust] of {scenario.name}, which are within {told}"


def _side(found: Robustness) -> Side:
    return Side(found.stable, found.nominal_stable, found.nominal, found.values, found.ranges)


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
        # Two without a number, that never settle say, are equal, as are two but for rounding.
        both = np.where((a == b) | np.isclose(a, b, SAME, 0.0), 0.0, np.log(a) - np.log(b))
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
