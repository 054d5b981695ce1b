"""Test of one design on unseen machines in every motion.

Three compiled programs simulate all motions each: one the machines, in the precision of the search;
two the nominal machine in float64, with its command multiplied by many factors, and with four times
the substeps.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hfc_design.core.numbers import Floats, Gains, Integers, Mask
from hfc_design.core.records import UserError
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.loop_setup import load_design, machine, with_converter
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.robust import RobustSettings
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Samples
from hfc_design.objectives.judge import Judged
from hfc_design.simulation import acceptance, population
from hfc_design.simulation.acceptance import LARGEST_TRIED, NO, TRIED, Usable
from hfc_design.simulation.closed_loop import Loop
from hfc_design.simulation.divergence import finer, refined
from hfc_design.simulation.loop_margins import loop_margins
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.monte_carlo import FEW, check_draw
from hfc_design.simulation.population import Machines, standing
from hfc_design.simulation.repeats import FACTORS, Repeats, of_all_motions, scaled_command
from hfc_design.simulation.stress import AT_ONCE, longest, stressed
from hfc_design.simulation.why_not import why_not
from hfc_design.stability.report import LoopMargins

#: Spread and number of machines for a scenario without ``[robust]``.
SPREAD, MACHINES = 0.2, 200
#: The machines are drawn with the seed of the run plus this number, with which no search draws.
BEYOND = 2**32


def usable(
    design: AnyDesign,
    scenario: AnyScenario,
    spread: float | None = None,
    machines: int | None = None,
    seed: int | None = None,
) -> Usable:
    """Test ``design`` in every motion of ``scenario`` on machines that no search has seen.

    ``[robust]`` of the scenario sets number and tolerances of the machines (without ``margin``);
    without ``[robust]`` there are ``MACHINES`` machines within ``SPREAD``. They are uniform draws
    with the seed of the run plus ``BEYOND``. ``spread``, ``machines`` and ``seed`` override these
    settings; ``spread`` also replaces the tolerances of single parameters.

    Raises:
        UserError: design and scenario do not fit, a number is not allowed, or it leaves no machine.
    """
    design = load_design(design)
    scenario = with_converter(load_scenario(scenario), design)
    robust = scenario.robust or RobustSettings(spread=SPREAD, unseen=MACHINES)
    if spread is not None:  # also in place of the tolerances of single parameters
        robust = robust.model_copy(update={"spread": spread, "tolerances": {}})
    seed = scenario.run.seed + BEYOND if seed is None else seed
    count = robust.unseen if machines is None else machines
    check_draw(robust.spread, count, seed, number="machines")
    parts = (robust.spread, count, seed, robust.tolerances)
    key = "robust.spread" if spread is None else None
    some, _ = drawn(machine(design, scenario), *parts, key=key)
    under = scenario.robust is not None or "stress" in scenario.model_fields_set
    setup = _InUse.of(design, scenario, scenario.stress.delay_samples if under else None)
    each = enumerate(scenario.each_motion())
    with ThreadPoolExecutor(1) as pool:  # compiles while the machines are simulated
        in_gain = pool.submit(_gain, design, scenario, some)
        margins = pool.submit(_margins, design, scenario, some)
        finely = pool.submit(_finely, design, scenario, some)
        judged = setup.on_machines(design, some)
        once, gain, repeats = in_gain.result()
        motions = tuple(acceptance.motion_result(scenario, judged, k, one) for k, one in each)
        off = _change(merit(scenario, judged.merit[:1]), once)
        details = (gain, off, None, acceptance.units(scenario), margins.result(), repeats)
        result = Usable(robust.spread, seed, motions, *details, required_margins=scenario.margins)
        if result.verdict == NO:
            about = (scenario, robust, some, judged, setup.judged)
            result = result._replace(why_not=why_not(*about, result.short))
        elif under:
            crossover = result.margins and result.margins.crossover
            stress = stressed(scenario, setup.loop, setup.gains, some, judged, crossover)
            result = result._replace(stress=stress)
    fine = finely.result()
    return result if fine is None else result._replace(substeps=_change(fine, once))


def unseen(design: Design, scenario: Scenario, count: int, seed: int = 0) -> Machines:
    """Return the nominal machine and ``count`` unseen ones within the scenario's tolerances.

    Others for each ``seed``.
    """
    robust = scenario.robust or RobustSettings(spread=SPREAD)
    parts = (robust.spread, count, scenario.run.seed + BEYOND + seed, robust.tolerances)
    return drawn(machine(design, scenario), *parts, key="robust.spread")[0]


def _margins(design: Design, scenario: Scenario, machines: Machines) -> LoopMargins | None:
    """Return the margins of the loop; None if it cannot be linearised."""
    try:
        return loop_margins(design, scenario, machines)
    except UserError:
        return None


def merit(scenario: Scenario, merits: ArrayLike) -> float:
    """Return the first individual's merit over all motions, from merits (individuals, motions)."""
    return float(of_all_motions(scenario, np.asarray(merits)[:1])[0])


class _InUse(NamedTuple):
    """A loop in the motions of a scenario, with the metrics that decide whether it is usable."""

    scenario: Scenario
    later: float | None  # additional delay that the loop has room for; None: no stress
    loop: Loop
    gains: Gains
    samples: list[Samples]

    @classmethod
    def of(cls, design: Design, scenario: Scenario, later: float | None = None) -> "_InUse":
        samples = [motion.samples() for motion in scenario.each_motion()]
        return cls(scenario, later, *acceptance.measured_loop(design, scenario, later), samples)

    def judged(self, machines: Machines) -> Judged:
        """Return results (machines, motions), by the program of the stresses if there are any."""
        shared = () if self.later is None else (AT_ONCE, longest(self.scenario))
        many, dtype = standing(machines, self.scenario, self.loop), self.scenario.run.precision
        scores = population.scores(self.loop, many, self.samples, self.gains, dtype, *shared)
        return Judged(*(np.array(part[0]) for part in scores))

    def on_machines(self, design: Design, machines: Machines) -> Judged:
        """Return results (machines, motions); machines that diverge are repeated in finer steps."""

        def simulate(where: Scenario, chosen: Integers) -> list[Judged]:
            if where is self.scenario:
                return self.judged(machines).rows
            some = machines.take(np.resize(chosen, -(-len(chosen) // FEW) * FEW))
            return _InUse.of(design, where).judged(some).rows[: len(chosen)]

        count = machines.size
        rows = refined(self.scenario, count, simulate, lambda row: bool(row.failed.any()))
        return Judged.stacked(rows)


def _gain(
    design: Design, scenario: Scenario, machines: Machines
) -> tuple[float, tuple[float, float] | None, Repeats]:
    """Return merit, passing range of factors, and repeats of the nominal machine, in float64."""
    setup, nominal = _InUse.of(design, scenario), machines.take(np.zeros(1, int))

    def judged(factors: Floats) -> Judged:
        loop, many = scaled_command(setup.loop, setup.gains, factors)
        scores = population.scores(loop, nominal, setup.samples, many, np.float64)
        return Judged(*(part[:, 0] for part in scores))

    def passes(factors: Floats) -> Mask:
        scores = judged(np.append(1.0, factors))
        bad = np.logical_or.reduce([*acceptance.broken_by(scenario, scores).values()])
        return np.asarray(~bad.any(axis=1))

    each = judged(FACTORS)
    repeats = Repeats(of_all_motions(scenario, each.rank))
    return merit(scenario, each.merit), gain_range(passes), repeats


def _finely(design: Design, scenario: Scenario, machines: Machines) -> float | None:
    """Return the merit of the nominal machine in finer steps; None: these are not possible."""
    where = next(finer(scenario), None)
    if where is None:
        return None
    setup, nominal = _InUse.of(design, where), machines.take(np.zeros(1, int))
    scores = population.scores(setup.loop, nominal, setup.samples, setup.gains, np.float64)
    return merit(where, scores.merit[0])


def _change(one: float, other: float) -> float:
    with np.errstate(all="ignore"):
        return float(abs(np.float64(one) / other - 1.0))


def gain_range(passes: Callable[[Floats], Mask]) -> tuple[float, float] | None:
    """Return lowest and highest factor with which a machine passes; None: it does not with 1.

    ``passes(factors)`` tells whether it passes with the factor 1, and with each of ``factors``. The
    scan is geometric, from ``SMALLEST_TRIED`` to ``LARGEST_TRIED``; then both ends are refined.
    """
    up = np.geomspace(1.0, LARGEST_TRIED, TRIED + 1)
    grids, ends = [up, 1.0 / up[:-1]], list[tuple[float, float]]()
    for _ in range(2):  # the second time between the last factor that passes and the next one
        good = passes(np.concatenate([grid[1:] for grid in grids]))
        if not good[0]:
            return None
        passed = good[: TRIED + 1], np.append(True, good[TRIED + 1 :])
        lasts = [int(np.append(some, False).argmin()) - 1 for some in passed]
        pairs = [*zip(grids, lasts, strict=True)]
        ends = [(float(grid[k]), float(grid[min(k + 1, len(grid) - 1)])) for grid, k in pairs]
        counts = [len(grid) for grid in grids]
        grids = [np.geomspace(*end, n + 1)[:-1] for n, end in zip(counts, ends, strict=True)]
    (high, _), (low, _) = ends
    return low, high
