"""Can it be used? One design on machines that no search has seen, in every motion.

In one compiled program each, all motions together: the machines, in the precision of the search;
the nominal machine with its whole command times many factors, in float64; the nominal machine in
four times the substeps.
"""

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from hfc_design.core.numbers import Floats, Gains, Mask
from hfc_design.core.records import UserError
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import (
    controller_of,
    load_design,
    machine,
    with_converter,
)
from hfc_design.files.robust import RobustSettings
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.judge import Judged
from hfc_design.simulation import population
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.divergence import finer
from hfc_design.simulation.gain_range import gain_range
from hfc_design.simulation.in_use import Usable
from hfc_design.simulation.loop_margins import loop_margins
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.measured_in_use import in_motion, loop_in_use, not_kept, units
from hfc_design.simulation.monte_carlo import FEW, check_draw
from hfc_design.simulation.population import Machines, standing
from hfc_design.simulation.repeats import FACTORS, Repeats, averaged, louder
from hfc_design.simulation.stress import AT_ONCE, longest, stressed
from hfc_design.simulation.stressed import NO
from hfc_design.simulation.why_not import why_not
from hfc_design.stability.report import LoopMargins

#: Of a scenario that says nothing about tolerances.
SPREAD, MACHINES = 0.2, 200
#: The machines are drawn with the seed of the run and this beyond it, which no search draws with.
BEYOND = 2**32


def usable(
    design: AnyDesign,
    scenario: AnyScenario,
    spread: float | None = None,
    machines: int | None = None,
    seed: int | None = None,
) -> Usable:
    """What ``design`` does in every motion of ``scenario`` on machines that no search has seen.

    ``[robust]`` of the scenario says how many and how different (without its margin); without it
    ``MACHINES`` within ``SPREAD``. They are uniform draws with the seed of the run plus ``BEYOND``.
    ``spread``, ``machines`` and ``seed`` take the place of these.

    Raises:
        UserError: the two do not fit, a number is not allowed, or the tolerances leave no possible
            machine.
    """
    design = load_design(design)
    scenario = with_converter(load_scenario(scenario), design)
    robust = scenario.robust or RobustSettings(spread=SPREAD, unseen=MACHINES)
    if spread is not None:  # whatever is known of single parameters
        robust = robust.model_copy(update={"spread": spread, "tolerances": {}})
    seed = scenario.run.seed + BEYOND if seed is None else seed
    count = robust.unseen if machines is None else machines
    check_draw(robust.spread, count, seed, option="--machines")
    parts = (robust.spread, count, seed, robust.tolerances)
    key = "robust.spread" if spread is None else "--spread"
    some, _ = drawn(machine(design, scenario), *parts, key=key)
    under = scenario.robust is not None or "stress" in scenario.model_fields_set
    later = scenario.stress.delay_samples if under else None
    judged, standing_in = _on_machines(design, scenario, some, later)
    nominal = some.take(np.zeros(1, int))
    exact, gain, repeats = _gain(design, scenario, nominal)
    once = merit(scenario, exact.merit)
    each = enumerate(scenario.each_motion())
    found = Usable(
        robust.spread,
        seed,
        tuple(in_motion(scenario, judged, k, one) for k, one in each),
        gain,
        _change(merit(scenario, judged.merit[:1]), once),
        _substeps(design, scenario, nominal, once),
        units(scenario),
        _margins(design, scenario, some),
        repeats,
        asked=scenario.margins,
    )
    if found.verdict == NO:
        again = partial(_again, scenario, standing_in, later)
        steady = found.loop_stable is not False
        return found._replace(why_not=why_not(scenario, robust, some, judged, again, steady))
    if not under:
        return found
    crossover = found.margins and found.margins.crossover
    return found._replace(stress=stressed(scenario, *standing_in, some, judged, crossover))


def _margins(design: Design, scenario: Scenario, machines: Machines) -> LoopMargins | None:
    """None of a loop that cannot be linearised."""
    try:
        return loop_margins(design, scenario, machines)
    except UserError:
        return None


def merit(scenario: Scenario, merits: ArrayLike) -> float:
    """Of the first of (individuals, motions) merits, of all motions together."""
    return float(_merits(scenario, np.asarray(merits)[:1])[0])


def _merits(scenario: Scenario, merits: Floats) -> Floats:
    """(individuals,) of (individuals, motions)."""
    weights = np.array([motion.weight for motion in scenario.motions] or [1.0])
    if merits.shape[1] == 1:
        return merits[:, 0]
    return averaged(merits, weights)


def _on_machines(
    design: Design, scenario: Scenario, machines: Machines, later: float | None
) -> tuple[Judged, tuple[Loop, Gains]]:
    """(machines, motions) of each, and the loop, with room for a command ``later`` by that.

    What diverges is simulated again in finer steps.
    """
    loop, gains = loop_in_use(design, scenario, later)
    about = (gains, scenario.run.precision)
    judged = _again(scenario, (loop, gains), later, machines)
    for where in finer(scenario):
        again = np.flatnonzero(judged.failed.any(axis=1))
        if not len(again):
            break
        some = machines.take(np.resize(again, -(-len(again) // FEW) * FEW))
        finely, _ = loop_in_use(design, where)
        each = [motion.samples() for motion in where.each_motion()]
        found = population.scores(finely, standing(some, where, finely), each, *about)
        for part, new in zip(judged, found, strict=True):
            part[again] = new[0, : len(again)]
    return judged, (loop, gains)


def _again(
    scenario: Scenario, standing_in: tuple[Loop, Gains], later: float | None, machines: Machines
) -> Judged:
    """(machines, motions) of each, in one program with all stresses if there are any."""
    loop, gains = standing_in
    samples = [motion.samples() for motion in scenario.each_motion()]
    shared = () if later is None else (AT_ONCE, longest(scenario))
    many, dtype = standing(machines, scenario, loop), scenario.run.precision
    found = population.scores(loop, many, samples, gains, dtype, *shared)
    return Judged(*(np.array(part[0]) for part in found))


def _gain(
    design: Design, scenario: Scenario, nominal: Machines
) -> tuple[Judged, tuple[float, float] | None, Repeats]:
    """The nominal machine in float64, the factors between which it passes, repeats."""
    once, gains = loop_in_use(design, scenario)
    samples = [motion.samples() for motion in scenario.each_motion()]

    def judged(factors: Floats) -> Judged:
        loop, many = louder(once, gains, factors)
        found = population.scores(loop, nominal, samples, many, np.float64)
        return Judged(*(part[:, 0] for part in found))

    def kept(factors: Floats) -> Mask:
        found = judged(np.append(1.0, factors))
        bad = np.logical_or.reduce([*not_kept(scenario, found).values()])
        return np.asarray(~bad.any(axis=1))

    found = judged(FACTORS)
    ranks = np.where(found.failed, -np.inf, found.merit)
    return found, gain_range(kept), Repeats(_merits(scenario, ranks))


def _substeps(design: Design, scenario: Scenario, nominal: Machines, once: float) -> float | None:
    where = next(finer(scenario), None)
    if where is None:
        return None
    controller, gains = controller_of(design, where)
    loop = closed_loop(where, controller)
    samples = [motion.samples() for motion in where.each_motion()]
    found = population.scores(loop, nominal, samples, gains, np.float64)
    return _change(merit(where, found.merit[0]), once)


def _change(one: float, other: float) -> float:
    with np.errstate(all="ignore"):
        return float(abs(np.float64(one) / other - 1.0))
