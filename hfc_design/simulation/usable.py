"""Can it be used? One design on machines that no search has seen, in every motion.

In one compiled program each, all motions together: the machines, in the precision of the search;
the nominal machine with its whole command times many factors, in float64; the nominal machine in
four times the substeps.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hfc_design.core.numbers import Floats, Gains, Json, Mask
from hfc_design.core.records import UserError
from hfc_design.core.statistics import share_interval
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.pairing import (
    controller_of,
    load_design,
    machine,
    open_loops,
    with_converter,
)
from hfc_design.files.robust import RobustSettings
from hfc_design.files.scenario import AnyScenario, Scenario, load_scenario
from hfc_design.objectives.constraints import Constraint, constraints_on
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.measures import MEASURES, Measure
from hfc_design.simulation import population
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.divergence import finer
from hfc_design.simulation.gain_range import FACTORS, Louder, gain_range
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.monte_carlo import ENOUGH
from hfc_design.simulation.population import Machines
from hfc_design.simulation.settling import STABILITY, faults
from hfc_design.stability.margins import margins

#: Of a scenario that says nothing about tolerances.
SPREAD, MACHINES = 0.2, 200
#: The machines are drawn with the seed of the run and this beyond it, which no search draws with.
BEYOND = 2**32
#: What motions that never rest may not show.
UNSTABLE = (
    "at rest its linear loop swings by itself (hfc stability tells more, a motion that holds a "
    "position would show it)"
)


class InMotion(NamedTuple):
    """What many machines do in one motion; the nominal one is not among them."""

    name: str
    good: Mask  # (machines,) stable, and within every constraint
    reasons: dict[str, int]  # why some are not -> how many
    told: dict[str, Floats]  # measure -> (machines,)
    nominal: dict[str, float]
    nominal_reasons: tuple[str, ...]  # none of a nominal machine that keeps everything
    bounds: dict[str, tuple[float, Floats]]  # constraint -> allowed, and (machines + 1,) measured
    everywhere: bool = True  # whether it is asked of all machines, and not of the nominal one alone


class Usable(NamedTuple):
    """What can be said about using a design."""

    spread: float
    seed: int
    motions: tuple[InMotion, ...]
    gain: tuple[float, float] | None  # factors on the command between which all is kept
    precision: float  # change of the merit from float32 to float64, as a share
    substeps: float | None  # the same to four times the substeps; None: not allowed
    units: dict[str, str]  # of the measures
    loop_stable: bool | None  # of the nominal machine at rest, where there is a linear loop

    @property
    def good(self) -> Mask:
        """(machines,) that keep everything in every motion."""
        return np.logical_and.reduce([one.good for one in self.asked])

    @property
    def asked(self) -> tuple[InMotion, ...]:
        """The motions that are asked of all machines."""
        return tuple(one for one in self.motions if one.everywhere)

    @property
    def interval(self) -> tuple[float, float]:
        """Of the share of such machines, by Clopper and Pearson."""
        return share_interval(int(self.good.sum()), len(self.good))

    @property
    def yes(self) -> bool:
        """Whether the nominal machine keeps everything, and nearly all of the others do."""
        calm = self.loop_stable is not False and not self._nominal
        return calm and bool(self.good.mean() >= ENOUGH)

    @property
    def _nominal(self) -> list[str]:
        """Why the nominal machine does not keep everything."""
        return [f"it {x} in {one.name}" for one in self.motions for x in one.nominal_reasons]

    @property
    def answer(self) -> str:
        """Yes, or no and why, in a line."""
        share, count = float(self.good.mean()), len(self.good)
        machines = f"{_percent(share)} of {count} unseen machines within +-{100 * self.spread:g} %"
        every = " in every motion" if len(self.motions) > 1 else ""
        if self.yes:
            return f"yes: {machines} keep everything{every}"
        if self.loop_stable is False and not self._nominal:
            return f"no: {UNSTABLE}; {machines} keep everything{every}"
        if why := self._nominal:
            more = f" and {len(why) - 1} more" if len(why) > 1 else ""
            return f"no: on the nominal machine {why[0]}{more}; {machines} keep everything{every}"
        worst = min(self.asked, key=lambda one: float(one.good.mean()))
        reason = max(worst.reasons, key=lambda why: worst.reasons[why])
        lost = f"{worst.reasons[reason]} {several(reason)}"
        if worst.reasons[reason] == 1:
            lost = f"1 {reason}"
        if not share:
            return f"no: no machine of {count} keeps everything; {lost} in {worst.name}"
        return f"no: only {machines} keep everything; {lost} in {worst.name}"

    def numbers(self) -> Json:
        """Everything as plain data; None where there is no number."""
        low, high = self.interval
        return {
            "usable": self.yes,
            "answer": self.answer,
            "spread": self.spread,
            "machines": len(self.good),
            "seed": self.seed,
            "share": float(self.good.mean()),
            "interval": [low, high],
            "loop_stable": self.loop_stable,
            "gain": None if self.gain is None else [*self.gain],
            "precision": _plain(self.precision),
            "substeps": None if self.substeps is None else _plain(self.substeps),
            "units": self.units,
            "motions": {one.name: _motion_numbers(one) for one in self.motions},
        }


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
        UserError: the two do not fit, or the tolerances leave no possible machine.
    """
    design = load_design(design)
    scenario = with_converter(load_scenario(scenario), design)
    robust = scenario.robust or RobustSettings(spread=SPREAD, unseen=MACHINES)
    if spread is not None:  # whatever is known of single parameters
        robust = robust.model_copy(update={"spread": spread, "tolerances": {}})
    seed = scenario.run.seed + BEYOND if seed is None else seed
    parts = (robust.spread, machines or robust.unseen, seed, robust.tolerances)
    key = "robust.spread" if spread is None else "--spread"
    some, _ = drawn(machine(design, scenario), *parts, key=key)
    motions = scenario.each_motion()
    judged = _on_machines(design, scenario, some)
    exact, gain = _gain(design, scenario, some.take(np.zeros(1, int)))
    once = merit(scenario, exact.merit)
    coarse = merit(scenario, judged.merit[:1])
    told = tuple(_told(scenario, judged, k, one) for k, one in enumerate(motions))
    units = {one.name: _unit(one, scenario) for one in _measures(scenario)}
    return Usable(
        robust.spread,
        seed,
        told,
        gain,
        _change(coarse, once),
        _substeps(design, scenario, some.take(np.zeros(1, int)), once),
        units,
        _loop_stable(design, scenario),
    )


def _loop_stable(design: Design, scenario: Scenario) -> bool | None:
    try:
        loops = open_loops(design, machine(design, scenario), scenario.limits)
    except UserError:  # the drive cannot be linearised
        return None
    return all(margins(loop).stable for loop in loops.values()) if loops else None


def merit(scenario: Scenario, merits: ArrayLike) -> float:
    """Of the first of (individuals, motions) merits, of all motions together."""
    weights = np.array([motion.weight for motion in scenario.motions] or [1.0])
    first = np.asarray(merits)[0]
    if len(first) == 1:
        return float(first[0])
    with np.errstate(all="ignore"):
        return float(weights.sum() / (weights @ (1.0 / first)))


def _measures(scenario: Scenario) -> tuple[Measure, ...]:
    tracking = "rms_contour_error" if scenario.follows_path else "settled_rms_error"
    return tuple(MEASURES[name] for name in (tracking, "chatter", "peak_command"))


def _unit(one: Measure, scenario: Scenario) -> str:
    return scenario.units.signals.get(one.unit, one.unit)


def _loop(design: Design, scenario: Scenario) -> tuple[Loop, Gains]:
    """Constraints, what is told, and ``STABILITY`` are measured, in this order."""
    controller, gains = controller_of(design, scenario)
    loop = closed_loop(scenario, controller)
    bounds = constraints_on(scenario.constraints, scenario.units)
    own = (*(bound.measure for bound in bounds), *_measures(scenario), *STABILITY)
    return loop._replace(judge=loop.judge._replace(measured=own)), gains


def _on_machines(design: Design, scenario: Scenario, machines: Machines) -> Judged:
    """(machines, motions) of each; what diverges is simulated again in finer steps."""

    def simulated(where: Scenario, some: Machines) -> Judged:
        loop, gains = _loop(design, where)
        samples = [motion.samples() for motion in where.each_motion()]
        found = population.scores(loop, some, samples, gains, scenario.run.precision)
        return Judged(*(np.array(part[0]) for part in found))

    judged = simulated(scenario, machines)
    for where in finer(scenario):
        again = np.flatnonzero(judged.failed.any(axis=1))
        if not len(again):
            break
        found = simulated(where, machines.take(np.resize(again, -(-len(again) // 16) * 16)))
        for part, new in zip(judged, found, strict=True):
            part[again] = new[: len(again)]
    return judged


def _kept(scenario: Scenario, judged: Judged) -> dict[str, Mask]:
    """Why individuals do not keep everything -> (individuals, motions) which; the nominal first."""
    failed = np.asarray(judged.failed)
    found = faults(np.asarray(judged.values), failed, scenario.each_motion())
    for name, (bound, values) in _bounds(scenario, judged).items():
        found[f"breaks {name}"] = ~(values <= bound.most) & ~failed
    return found


def _bounds(scenario: Scenario, judged: Judged) -> dict[str, tuple[Constraint, Floats]]:
    """Constraint -> itself, and (individuals, motions) what is measured."""
    bounds = constraints_on(scenario.constraints, scenario.units)
    values = np.asarray(judged.values)
    first = values.shape[-1] - len(STABILITY) - len(_measures(scenario)) - len(bounds)
    return {own.measure.name: (own, values[..., first + n]) for n, own in enumerate(bounds)}


def _told(scenario: Scenario, judged: Judged, k: int, motion: Scenario) -> InMotion:
    reasons = {why: mask[:, k] for why, mask in _kept(scenario, judged).items()}
    bounds = {
        name: (own, values[:, k]) for name, (own, values) in _bounds(scenario, judged).items()
    }
    over = {}
    for name, (bound, values) in bounds.items():
        unit = _unit(bound.measure, scenario)
        over[f"breaks {name}"] = f" ({values[0]:.3g} {unit}, allowed {bound.most:.3g})"
    bad = np.logical_or.reduce([*reasons.values()])
    own = _measures(scenario)
    first = judged.values.shape[-1] - len(STABILITY) - len(own)
    values = np.asarray(judged.values)[:, k]
    columns = {one.name: values[:, first + n] for n, one in enumerate(own)}
    limited = [one.name for one in STABILITY].index("limit_share") - len(STABILITY)
    columns["limit_share"] = values[:, limited]
    return InMotion(
        motion.name.rpartition(".")[2] if scenario.motions else motion.name,
        ~bad[1:],
        {why: int(mask[1:].sum()) for why, mask in reasons.items() if mask[1:].any()},
        {name: column[1:] for name, column in columns.items()},
        {name: float(column[0]) for name, column in columns.items()},
        tuple(why + over.get(why, "") for why, mask in reasons.items() if mask[0]),
        {name: (own.most, values) for name, (own, values) in bounds.items()},
        not scenario.nominal_only[k],
    )


def _gain(
    design: Design, scenario: Scenario, nominal: Machines
) -> tuple[Judged, tuple[float, float] | None]:
    """The nominal machine in float64, and the factors between which it keeps everything."""
    import jax

    loop, gains = _loop(design, scenario)
    loop = loop._replace(controller=Louder(loop.controller))
    samples = [motion.samples() for motion in scenario.each_motion()]
    wide = jax.tree.map(lambda leaf: np.repeat(leaf, 2 * FACTORS, axis=-1), gains)
    first: list[Judged] = []

    def kept(factors: Floats) -> Mask:
        """Of 1 and other factors; the last ones only fill up."""
        both = (np.append(1.0, factors), wide)
        found = population.scores(loop, nominal, samples, both, np.float64)
        judged = Judged(*(part[:, 0] for part in found))
        first.append(judged)
        bad = np.logical_or.reduce([*_kept(scenario, judged).values()])
        return np.asarray(~bad.any(axis=1))

    gain = gain_range(kept)
    return first[0], gain


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


def several(reason: str) -> str:
    """What one machine does, as several do it."""
    verb, blank, rest = reason.partition(" ")
    return ("are" if verb == "is" else verb.removesuffix("s")) + blank + rest


def _percent(share: float) -> str:
    return f"{100 * share:.4g} %"


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _motion_numbers(one: InMotion) -> Json:
    told = one.told.items()
    measured = {name: _numbers(one.nominal[name], column) for name, column in told}
    bounds = {
        name: {"allowed": most, **_numbers(values[0], values[1:])}
        for name, (most, values) in one.bounds.items()
    }
    return {
        "share": float(one.good.mean()),
        "reasons": one.reasons,
        "nominal": list(one.nominal_reasons),
        "asked_of": "all" if one.everywhere else "nominal",
        "measures": measured,
        "constraints": bounds,
    }


def _numbers(nominal: float, values: Floats) -> dict[str, float | None]:
    finite = values[np.isfinite(values)]
    quantiles = np.quantile(finite, [0.5, 0.95, 1.0]).tolist() if len(finite) else [None] * 3
    own = {"nominal": _plain(nominal)}
    return own | dict(zip(("median", "q95", "largest"), quantiles, strict=True))
