"""One design on many machines, whose parameters are spread about the nominal ones."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.core.arguments import check_share, check_type, check_whole
from hfc_design.core.numbers import SAME, Floats, Integers, Json, Mask, storable
from hfc_design.core.records import UserError, option
from hfc_design.core.statistics import Interval, share_interval
from hfc_design.core.tables import MISSING, Table, line, table
from hfc_design.core.wording import three_digits
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.loop_setup import controller_of, load_design, machine, with_converter
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.judge import Judged
from hfc_design.simulation import memory, population
from hfc_design.simulation.acceptance import ENOUGH, tolerated_metrics
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.divergence import refined
from hfc_design.simulation.evaluating import Evaluation, evaluate, evaluations, meanings
from hfc_design.simulation.machines import NONE, drawn
from hfc_design.simulation.population import Machines
from hfc_design.simulation.repeats import chaos_text
from hfc_design.simulation.stability_criteria import (
    STABILITY,
    instabilities,
    measuring,
    reasons_text,
)

Progress = Callable[[int, int], None]

#: Machines that are simulated together, at most; more of them are no faster.
CHUNK = 64
#: Machines that are simulated together if some are repeated: a fixed number, so that one compiled
#: program serves any number of repeats and every design of a kind.
FEW = 16
#: Samples of an axis that are kept at once, all machines together: about 80 MB.
KEPT = 1_000_000
MAX_SAMPLES = 1_000_000
REFUSED = "{} draws were replaced, as their parameters are impossible together"
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


class Robustness(NamedTuple):
    """Result of one design on machines with spread parameters."""

    spread: float
    seed: int
    machines: Machines  # the nominal one first
    refused_draws: int  # that gave no possible machine
    refined: int  # machines that were simulated again with shorter steps
    stable: Mask  # (samples,) of the drawn machines, without the nominal one
    nominal_stable: bool
    nominal: dict[str, float]  # fitness, merit and metrics; nan where there is none
    values: dict[str, Floats]  # the same numbers of the drawn machines, (samples,)
    motion: Evaluation  # of the nominal machine
    ranges: dict[str, Json]  # of the nominal machine's fitness and merit, where chaotic
    reasons: dict[str, int]  # why drawn machines are not stable -> how many
    nominal_reasons: tuple[str, ...]  # why the nominal machine is not stable
    meanings: dict[str, str]  # of each metric, with its unit; titles of fitness and merit

    def __repr__(self) -> str:
        return line("Robustness", self._summary())

    def _repr_html_(self) -> str:
        return table("Robustness", self._summary() | self.nominal)

    def _summary(self) -> dict[str, object]:
        stable = {"stable": float(self.stable.mean()), "nominal_stable": self.nominal_stable}
        return {"spread": self.spread, "machines": len(self.stable), **stable}

    @property
    def usable(self) -> bool:
        """Whether the nominal machine and at least a share ``ENOUGH`` of the others are stable."""
        return self.nominal_stable and bool(self.stable.mean() >= ENOUGH)

    @property
    def interval(self) -> Interval:
        """Confidence interval of the share of stable machines."""
        return share_interval(int(self.stable.sum()), len(self.stable))

    def spread_of(self, key: str) -> Floats:
        """Return a metric of all stable drawn machines that have it, in the order of the draws."""
        values = self.values[key][self.stable]
        return values[np.isfinite(values)]

    def quantiles(self, key: str) -> list[float]:
        """Return ``QUANTILES`` of ``spread_of(key)``, interpolated linearly; nan if it is empty."""
        values = self.spread_of(key)
        return np.quantile(values, QUANTILES).tolist() if len(values) else [np.nan] * len(QUANTILES)

    def tables(self) -> list[Table]:
        """Return a table with the quantiles of each metric over the machines."""
        head, rows = ("metric", "nominal", *(f"{100 * x:g} %" for x in QUANTILES), "count"), []
        for key, values in self.numbers()["metrics"].items():
            cells = [MISSING if x is None else three_digits(x) for x in values.values()]
            rows.append([key, *(["chaotic", *cells[1:]] if key in self.ranges else cells)])
        share, also = 100 * self.stable.mean(), "too" if self.nominal_stable else "is not"
        merit = f"; {self.meanings['merit']}" if "merit" in self.meanings else ""
        chaotic = {key: some for key, some in self.ranges.items() if key in self.nominal}
        lines = [
            f"{share:.4g} % of {len(self.stable)} machines are stable, the nominal one {also}",
            *[f"of the others {reasons_text(self.reasons)}"] * bool(self.reasons),
            f"quantiles of the stable ones that have the metric{merit}",
            *[REFUSED.format(self.refused_draws)] * bool(self.refused_draws),
            f"simulated again with shorter steps: {self.refined}",
            *(f"nominal {chaos_text(key, some)}" for key, some in chaotic.items()),
        ]
        return [Table(f"Parameters within ±{100 * self.spread:g} %.", head, rows, lines=lines)]

    def numbers(self) -> dict[str, Any]:
        """Return all but the numbers of single machines, for JSON; None for a missing number."""
        metrics = {}
        for key, nominal in self.nominal.items():
            quantiles = zip(QUANTILES, self.quantiles(key), strict=True)
            statistics = {"nominal": nominal} | {f"q{100 * q:02.0f}": x for q, x in quantiles}
            metrics[key] = storable(statistics) | {"count": len(self.spread_of(key))}
        return {
            "spread": self.spread,
            "samples": len(self.stable),
            "seed": self.seed,
            "stable_share": float(self.stable.mean()),
            "stable_interval": [*self.interval],
            "nominal_stable": self.nominal_stable,
            "reasons": self.reasons,
            "nominal_reasons": list(self.nominal_reasons),
            "refused_draws": self.refused_draws,
            "refined": self.refined,
            "repeats": self.ranges,
            "metrics": metrics,
        }


def robustness(
    design: AnyDesign,
    scenario: AnyScenario,
    spread: float,
    samples: int,
    seed: int = 0,
    progress: Progress = lambda done, total: None,
    tolerances: Mapping[str, float] = NONE,
) -> Robustness:
    """Simulate ``design`` on the nominal machine and ``samples`` others.

    ``tolerances`` are the spreads of single parameters. A motion that diverges is simulated again
    in finer steps, as ``evaluate`` does. ``progress(done, total)`` is called after every chunk of
    machines.

    Raises:
        UserError: spread or samples are not allowed, or design and scenario do not fit.
    """
    design = load_design(design)
    scenario = with_converter(load_scenario(scenario), design)
    if scenario.motions:
        one = f"one motion, scenario.motion({scenario.motions[0].name!r})"
        many = f"{scenario.name} has several motions"
        raise UserError(f"{many}: use usable(design, scenario), or {one}")
    check_draw(spread, samples, seed, tolerances)
    drawing = {option("samples"): memory.MACHINE * samples}
    memory.check(scenario.name, memory.of_motion(scenario) | drawing)
    machines, refused = drawn(machine(design, scenario), spread, samples, seed, tolerances)
    _check_steps(scenario, machines)
    again: list[int] = []

    def simulate(where: Scenario, chosen: Integers) -> Iterator[tuple[Evaluation, Judged]]:
        first = where is scenario
        again.extend([] if first else [len(chosen)])
        before, at_once = (0, min(CHUNK, machines.size)) if first else (machines.size, FEW)

        def more(done: int, total: int) -> None:
            progress(before + done, before + total)

        return _motions(design, where, machines.take(chosen), more, at_once)

    pairs = refined(scenario, machines.size, simulate, lambda result: result[0].diverged)
    evaluations, judged = zip(*pairs, strict=True)
    _, measured, failed = map(np.asarray, Judged.stacked(judged))
    lost = failed | np.array([[one.diverged] for one in evaluations])
    why = {reason: mask[:, 0] for reason, mask in instabilities(measured, lost, [scenario]).items()}
    stable = ~np.logical_or.reduce([*why.values()])
    reasons = {reason: int(mask[1:].sum()) for reason, mask in why.items() if mask[1:].any()}
    nominal_reasons = tuple(reason for reason, mask in why.items() if mask[0])
    columns, meant = _columns(scenario, evaluations, np.where(lost, np.nan, measured[:, 0]))
    nominal = {key: float(column[0]) for key, column in columns.items()}
    values = {key: column[1:] for key, column in columns.items()}
    ranges = evaluate(design, scenario).ranges
    parts = (stable[1:], bool(stable[0]), nominal, values, evaluations[0], ranges, reasons)
    repeated = again[0] if again else 0
    return Robustness(spread, seed, machines, refused, repeated, *parts, nominal_reasons, meant)


def _columns(
    scenario: Scenario, evaluations: Sequence[Evaluation], measured: Floats
) -> tuple[dict[str, Floats], dict[str, str]]:
    """Return scores, metrics and metrics with a target, (machines,) each, and meanings, by key.

    ``measured`` (machines, values) ends with metrics with a target and ``STABILITY``, or is nan.
    """
    judge = scenario.judge()
    scores = [one.score(judge) for one in evaluations]
    keys = (*judge.titles, *evaluations[0].metrics)
    columns = {key: np.array([score[key] for score in scores], float) for key in keys}
    meant = {**judge.titles, **meanings(scenario)}
    tolerated = tolerated_metrics(scenario)
    for n, (key, (_, meaning)) in enumerate(tolerated.items(), -len(tolerated) - len(STABILITY)):
        if key not in meant:  # otherwise it is among the metrics already
            columns[key], meant[key] = measured[:, n], meaning
    return columns, meant


def _motions(
    design: Design, scenario: Scenario, machines: Machines, progress: Progress, at_once: int
) -> Iterator[tuple[Evaluation, Judged]]:
    """Yield for each machine its evaluation, and the results that ``instabilities`` needs.

    At most ``at_once`` machines are simulated together. Only the first evaluation has its motion.
    """
    controller, gains = controller_of(design, scenario)
    loop, samples, count = closed_loop(scenario, controller), scenario.samples(), machines.size
    room = KEPT // (scenario.simulation.steps * len(loop.machine.axes))
    size = max(min(at_once, room), 1)
    one, wide = gains, lambda leaf: np.broadcast_to(leaf, (*leaf.shape[:-1], size))
    gains = jax.tree.map(wide, gains)
    machines = population.standing(machines, scenario, loop)
    measured = measuring(loop, (measure for measure, _ in tolerated_metrics(scenario).values()))
    for start in range(0, count, size):
        # The last chunk is filled up with its last machine: one shape, one compilation.
        some = machines.take(np.minimum(np.arange(start, start + size), count - 1))
        judged = population.scores(measured, some, [samples], one, np.float64)
        (each,) = evaluations([scenario], loop, some, gains)
        for k, evaluation in enumerate(islice(each, count - start), start):
            reduced = evaluation._replace(time=np.empty(0), axes=(), contour=None)
            if k == 0:  # copied: otherwise it would keep the arrays of the whole chunk in memory
                copies = jax.tree.map(np.copy, [x.motion for x in evaluation.axes])
                pairs = zip(evaluation.axes, copies, strict=True)
                reduced = evaluation._replace(axes=tuple(x._replace(motion=y) for x, y in pairs))
            yield reduced, Judged(*(x[0, k - start] for x in judged))
        progress(min(start + size, count), count)


def check_draw(
    spread: float,
    samples: int,
    seed: int,
    tolerances: Mapping[str, float] = NONE,
    number: str = "samples",
) -> None:
    """Raise UserError for a value that is not allowed; messages call ``samples`` ``number``."""
    check_share("spread", spread)
    check_type(tolerances, Mapping, "a mapping of parameters to tolerances")
    for name, tolerance in tolerances.items():
        check_share("tolerance", tolerance, argument="tolerances", key=name)
    check_whole(number, samples, 1, MAX_SAMPLES)
    check_whole("seed", seed, 0)


def _check_steps(scenario: Scenario, machines: Machines) -> None:
    """Raise UserError if the integration steps are too long for any of the machines."""
    substeps, drives, needed = scenario.simulation.substeps, scenario.plant.machine.drives, 0
    step = scenario.simulation.sample_time_s / substeps
    each = zip(drives, machines.actual, scenario.samples().axes, strict=True)
    for drive, parameters, happens in each:
        rows = (type(parameters)(*row) for row in zip(*parameters, strict=True))
        limit = min(drive.fastest(row, step) for row in rows)
        speed = np.abs(happens.reference_rate).max() * (1.0 - SAME)
        needed = max(needed, np.ceil(substeps * speed / limit))
    if needed > substeps:
        setting = f"scenario {scenario.name}: simulation.substeps = {substeps}"
        raise UserError(f"{setting}: must be at least {needed:.0f} for some of these machines")
