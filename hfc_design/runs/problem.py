"""What a search needs of a scenario, and what becomes of its individuals: designs."""

from pathlib import Path
from typing import Any

import numpy as np

from hfc_design import __version__
from hfc_design.controllers.genome import Genome, Population, joined, taken
from hfc_design.controllers.kind import kinds
from hfc_design.core.numbers import Floats, Gains, Integers, Json
from hfc_design.core.plugins import References, own_code, sources
from hfc_design.core.records import RunError, checked
from hfc_design.files.design import Design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.pairing import check_laws, controller_of
from hfc_design.files.scenario import Scenario, renamed
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.verdict import Ensemble
from hfc_design.search.loop import STRATEGIES, Search
from hfc_design.search.newton import Linear
from hfc_design.search.strategy import Scored, Task
from hfc_design.simulation import memory
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.evaluation import Evaluation, evaluate
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import Machines

#: This many of the archive's best are simulated again in float64 before one is chosen.
FINALISTS = 16
#: A search whose scores are compared within a generation only begins with broken constraints of
#: so much, which it narrows down over this share of its generations.
LENIENT, NARROWED = 0.2, 0.6
#: Machines that the points of a front meet where a single design was looked for before.
HARD = 40
#: Power of ``robust.tighter`` that counts there: these machines are hard enough.
TRADED = 0.5
#: What to try where a search found nothing that stays finite.
HINTS = (
    "try a larger simulation.substeps or search.population, smaller gains or ranges, a shorter "
    "simulation.duration_s, another run.seed or start"
)
SPREAD_HINT = "try a smaller robust.spread; "
#: In the score of a design: none that was tried keeps every constraint, this one breaks them least.
LEAST_VIOLATED = "least_violated"


class Problem:
    """A scenario as what a search needs of it; UserError: its controller cannot be searched."""

    def __init__(self, scenario: Scenario, final: bool = False):
        with own_code("", *_kinds(scenario.controller.model_dump())):
            self.genome = genome_of(scenario)
            design = design_of(taken(self.genome.empty(), slice(1)), scenario)
        check_laws(design, scenario.plant.machine)
        controller, _ = controller_of(design, scenario)  # that of any individual
        self._loop = closed_loop(scenario, controller)
        self._machines = simulate.one_machine(scenario.plant.values())
        self._samples = [motion.samples() for motion in scenario.each_motion()]
        self._dtype = np.dtype(scenario.run.precision)
        self._ensemble, self._robust = scenario.ensemble, scenario.robust
        if self._robust:
            wider = 1.0 if final else self._robust.margin
            self._machines = drawn_for(scenario, self._robust.final - 1, scenario.run.seed, wider)
        self._allowed = self._traded_by = self._ensemble
        if self._robust and self._allowed and not final:
            self._ensemble = self._allowed.tighter(self._robust.tighter)
            self._traded_by = self._allowed.tighter(self._robust.tighter**TRADED)
        self._traded, self._record = scenario.traded, design.controller
        #: Generations of which each has machines of its own.
        self._fresh = STRATEGIES.get(scenario.search.preset).forgets(scenario.search)

    def rank(self, population: Population, generation: int = 0) -> Floats:
        """Merit of every individual; -inf where it failed, negative where it is not allowed.

        Of many machines everybody meets a few, the best of them more. Where scores of different
        generations are never compared, each generation has others of the same machines.
        """
        robust, lenient = self._robust, self._lenient(generation)
        if robust is None:
            return self._ranked(population, np.zeros(1, int), lenient)
        rank = self._ranked(population, self._some(robust.first, generation), lenient)
        for count in (robust.machines, robust.elite):
            if count == robust.first:
                continue
            # So many that it costs no more than the first round; the others cannot pass them.
            best = np.argsort(-rank, kind="stable")[: max(len(rank) * robust.first // count, 1)]
            found = self._ranked(taken(population, best), self._some(count, generation), lenient)
            rank = np.minimum(rank, found.min())
            rank[best] = found
        return rank

    def scored(
        self, population: Population, generation: int = 0, machines: Integers | None = None
    ) -> Floats | Scored:
        """What the strategy of the scenario is told: ranks, or with them what it trades off.

        Costs that are compared are those of the same ``machines``, without them the first ones.
        """
        if not self._traded:
            return self.rank(population, generation)
        if generation < self._fresh:  # before it trades
            rank = self.rank(population, generation)
            unknown = np.full((len(rank), len(self._traded)), np.inf)
            return Scored(rank, unknown, unknown[:, 0])
        count = self._robust.machines if self._robust else 1
        return self.weighed(population, np.arange(count) if machines is None else machines)

    def weighed(self, population: Population, machines: Integers | None = None) -> Scored:
        """Ranks, costs and violations on some machines, or on all that were drawn."""
        some = np.arange(self._machines.size) if machines is None else machines
        gains = self.genome.gains(population)
        judged = self._judged(gains, self._machines.take(some))
        rank, costs = self._rank(judged, self._traded_by), self._costs(judged, gains)
        violation = np.where(rank < 0.0, -rank, 0.0) if self._ensemble else np.zeros(len(rank))
        failed = ~(np.isfinite(rank) & np.isfinite(costs).all(axis=1))
        rank, violation = np.where(failed, -np.inf, rank), np.where(failed, np.inf, violation)
        return Scored(rank, costs, violation)

    def rank_of_finalists(self, population: Population) -> Floats:
        """What they are ranked by on all the machines that were drawn."""
        return self._ranked(population, np.arange(self._machines.size))

    def _lenient(self, generation: int) -> float:
        if generation >= self._fresh:
            return 0.0
        left = 1.0 - generation / (NARROWED * self._fresh)
        return LENIENT * max(left, 0.0) ** 2

    def _some(self, count: int, generation: int) -> Integers:
        """The nominal machine and some others: always the first ones, or others each time."""
        start = generation * (count - 1) if generation < self._fresh else 0
        return np.append(0, 1 + (start + np.arange(count - 1)) % (self._machines.size - 1))

    def _ranked(self, population: Population, machines: Integers, lenient: float = 0.0) -> Floats:
        some = self._machines.take(machines)
        judged = self._judged(self.genome.gains(population), some)
        return self._rank(judged, self._ensemble, lenient)

    def _judged(self, gains: Gains, machines: Machines) -> Judged:
        return simulate.scores(self._loop, machines, self._samples, gains, self._dtype)

    def _rank(self, judged: Judged, ensemble: Ensemble | None, lenient: float = 0.0) -> Floats:
        if ensemble is None:
            return np.asarray(judged.rank[:, 0, 0])
        return ensemble.verdict(judged, lenient).rank

    def _costs(self, judged: Judged, gains: Gains) -> Floats:
        """(n, objectives) what the search trades off."""
        first = len(self._loop.judge.objectives)
        values = np.asarray(judged.values)[..., first:]
        each = (self._ensemble or Ensemble((1.0,))).costs(values)
        measured = iter(each.T)  # those of constraints come last
        counted = kinds().get(self._record.kind).units
        columns = (
            next(measured) if one.measure else counted(self._record, gains) for one in self._traded
        )
        return np.stack([*columns], axis=1).astype(float)

    @property
    def task(self) -> Task:
        """What a strategy is given; a derivative only where there is one axis to follow."""
        alone = hasattr(self.genome, "space") and len(self._loop.machine.axes) == 1
        differs = alone and self._ensemble is None
        hardest = self._hardest if self._robust else None
        return Task(self.genome, self._linear if differs else None, hardest)

    def _hardest(self, population: Population) -> Integers:
        """The nominal machine and those on which most is broken.

        Left out are those that most of the ``population`` do not keep by the scenario's own limits.
        """
        assert self._ensemble is not None
        assert self._allowed is not None
        judged = self._judged(self.genome.gains(population), self._machines)
        kept = self._allowed.verdict(judged).sound.mean(axis=0) >= 0.5
        broken = self._ensemble.verdict(judged).broken.sum(axis=(2, 3)).mean(axis=0)
        others = 1 + np.argsort(-broken[1:], kind="stable")
        return np.sort(np.append(0, others[kept[others]][: HARD - 1]))

    def _linear(self, individual: Population) -> Linear | None:
        """The tracking error about one individual; None where it cannot be differentiated."""
        gains = self.genome.gains(individual)
        about = (self._loop, self._machines, *self._samples, gains, self._dtype)
        error, jacobian = simulate.error_jacobian(*about)
        finite = np.isfinite(error).all() and np.isfinite(jacobian).all()
        return Linear(error, jacobian) if finite else None


def drawn_for(scenario: Scenario, count: int, seed: int, margin: float = 1.0) -> Machines:
    """The nominal machine of a robust scenario and ``count`` others within its tolerances.

    These are wider by the factor ``margin``.
    """
    robust = scenario.robust
    assert robust is not None
    even = robust.sample == "latin-hypercube"
    wider = {name: margin * spread for name, spread in robust.tolerances.items()}
    parts = (scenario.plant, margin * robust.spread, count, seed, wider, even)
    return drawn(*parts, key="robust.spread")[0]


def check_memory(scenario: Scenario, design: Design | None = None, at_once: int = 1) -> None:
    """Refuse a run, or so many ``at_once``, that need more memory than there is.

    Raises:
        UserError: they do.
    """
    if design is None:
        with own_code("", *_kinds(scenario.controller.model_dump())):
            parts = memory.of_search(scenario, genome_of(scenario))
    else:
        parts = memory.of_motion(scenario)
    memory.check(scenario.name, parts, at_once)


def genome_of(scenario: Scenario) -> Genome:
    """What the search of ``scenario`` varies."""
    kind = kinds().get(scenario.controller.kind)  # with a genome, or the scenario could not name it
    genome: Genome = kind.genome(scenario.controller, scenario.target)
    return genome


def champion(
    search: Search, scenario: Scenario, one: Population | None = None
) -> tuple[Design, Evaluation]:
    """The best of the archive and of the last generation in float64, or that ``one``.

    float32 and a single try flatter loops that are nearly chaotic.

    Raises:
        RunError: all have diverged.
    """
    finalists, sound = _finalists(search) if one is None else [one], True
    if not finalists:
        tried = f"every individual diverged{_why(search, scenario)}"
        raise RunError(f"no design: {tried}; {SPREAD_HINT if scenario.robust else ''}{HINTS}")
    if scenario.ensemble and one is None:
        best, sound = _best_of_many(joined(*finalists), scenario)
        finalists = [best]
    designs = [design_of(individual, scenario) for individual in finalists]
    found = ((design, evaluate(design, scenario)) for design in designs)  # one motion at a time
    design, evaluation = max(found, key=lambda item: item[1].merit)
    if evaluation.diverged:
        why = f" ({evaluation.divergence})" if evaluation.divergence else ""
        raise RunError(f"no design: the best {len(designs)} diverge in float64{why}; {HINTS}")
    design = with_score(design, evaluation, scenario)
    if not sound:
        design = design.model_copy(update={"score": {**design.score, LEAST_VIOLATED: True}})
    return design, evaluation


def _best_of_many(finalists: Population, scenario: Scenario) -> tuple[Population, bool]:
    """The finalist that ranks first on machines within the tolerances, in float64.

    And whether it keeps every constraint on all of them; if not, nobody does.
    """
    rank = final_problem(scenario).rank_of_finalists(finalists)
    best = int(np.argmax(rank))
    return taken(finalists, np.array([best])), bool(rank[best] >= 0.0)


def final_problem(scenario: Scenario) -> Problem:
    """Where finalists compete: in float64, on machines within the tolerances themselves."""
    own = scenario.run.model_copy(update={"precision": "float64"})
    return Problem(scenario.model_copy(update={"run": own}), final=True)


def _why(search: Search, scenario: Scenario) -> str:
    """Why one of a population diverges that has all diverged; "" if nobody knows."""
    population = getattr(search.state, "population", None)
    if population is None:
        return ""
    lost = evaluate(design_of(taken(population, np.array([0])), scenario), scenario)
    if lost.divergence is None:
        return f" (one does not with simulation.substeps = {lost.substeps})"
    return f" ({lost.divergence})"


def _finalists(search: Search) -> list[Population]:
    """The best of the archive and of the last generation, without those that failed."""
    found = []
    sources: list[Any] = [search.archive]
    if {"population", "score"} <= set(getattr(search.state, "_fields", ())):
        sources.append(search.state)
    for source in sources:
        order = np.argsort(-source.score, kind="stable")[:FINALISTS]
        ranked = order[np.isfinite(source.score[order])]
        found += [taken(source.population, np.array([k])) for k in ranked]
    trail = getattr(search.state, "trail", None)
    if trail is not None:  # whatever they were worth on a few machines
        found += [taken(trail, np.array([k])) for k in range(len(trail.tree))]
    return found


def design_of(individual: Population, scenario: Scenario) -> Design:
    """A population of one as a design file."""
    return design_with(genome_of(scenario).record(individual), scenario)


def design_with(controller: Json, scenario: Scenario) -> Design:
    """A controller as a design file spells it, its sample time left out, for ``scenario``.

    Raises:
        UserError: it is no controller that can run.
    """
    own_parts = sources(parts_of(scenario, controller))
    movable = renamed(scenario, lambda key, file: Path(file.name))
    data = {
        "name": scenario.name,
        "plant": _plant(scenario.plant),
        "controller": {"sample_time_s": scenario.simulation.sample_time_s, **controller},
        "limits": scenario.limits.model_dump(exclude_none=True),
        "provenance": {
            "program": f"hfc-design {__version__}",
            **({"plugins": own_parts} if own_parts else {}),
            "scenario": movable.model_dump(mode="json", exclude_none=True),
        },
    }
    return checked(Design, data, f"{scenario.name}, kind {controller['kind']!r}", Path())


def parts_of(scenario: Scenario, controller: Json) -> References:
    """Group and name of everything that a scenario and a controller name."""
    used = [("plant", scenario.plant.name), ("fitness", scenario.fitness.kind)]
    return [*used, ("strategy", scenario.search.preset), *_kinds(controller)]


def _kinds(controller: Json) -> References:
    """Every kind of a controller or of its settings, that of each axis too."""
    each = [controller, *controller.get("axes", {}).values()]
    return [("controller", own["kind"]) for own in each]


def _plant(settings: PlantSettings) -> dict[str, object]:
    """The machine in full, so that the design does not depend on a program's defaults."""
    found = [record._asdict() for record in settings.values()]
    if len(found) == 1 and not settings.axes:
        return {"name": settings.name, "parameters": found[0]}
    axes = dict(zip(settings.machine.axes, found, strict=True))
    return {"name": settings.name, "parameters": {}, "axes": axes}


def with_score(design: Design, evaluation: Evaluation, scenario: Scenario) -> Design:
    """The design with its fitness, merit and metrics on a scenario."""
    score: Json = {"scenario": scenario.name, **evaluation.score(scenario.judge())}
    if evaluation.substeps > scenario.simulation.substeps:
        score["substeps"] = evaluation.substeps  # it diverges with fewer
    return design.model_copy(update={"score": score})
