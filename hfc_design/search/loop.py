"""The loop of every search strategy: ask, score, tell, remember the best of each structure."""

from collections.abc import Callable, Iterator
from functools import partial
from types import SimpleNamespace
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import SerializeAsAny

from hfc_design.controllers.genome import Genome, Population, joined, taken
from hfc_design.core.checkpoint import flat
from hfc_design.core.numbers import Floats, Integers
from hfc_design.core.plugins import Group, chosen, found_in, own_code
from hfc_design.search import strategies
from hfc_design.search.strategy import (
    Scored,
    Searcher,
    State,
    Strategy,
    StrategySettings,
    Task,
    Weighed,
)


def _fault(strategy: Strategy) -> str | None:
    """Return a line on what a strategy lacks; None if nothing is visibly missing."""
    fields = getattr(strategy.state, "_fields", ())
    return None if fields else "state must be a NamedTuple class"


STRATEGIES: Group[Strategy] = Group(
    "strategy", (Strategy,), "hfc_design.strategies", found_in(strategies, "STRATEGY"), fault=_fault
)
#: The ``[search]`` of a scenario.
SearchSettings = Annotated[
    SerializeAsAny[StrategySettings], chosen(STRATEGIES, "settings", "preset", default="race")
]


def searcher(settings: StrategySettings, task: Task) -> Searcher:
    """Return the strategy that ``settings`` name, at work on a task; UserError: it has an error."""
    strategy = STRATEGIES.get(settings.preset)
    with own_code(" cannot search: make", ("strategy", strategy.name)):
        instance = strategy.make(settings, task)
        methods = {part: getattr(instance, part) for part in ("start", "ask", "tell")}
    watched: Any = {part: partial(_called, strategy, part, x) for part, x in methods.items()}
    return SimpleNamespace(**watched)


def _called(strategy: Strategy, part: str, function: Callable[..., Any], *given: Any) -> Any:
    """Return the result of a strategy's function; errors of a user's own become a UserError."""
    with own_code(f" cannot search: {part}", ("strategy", strategy.name)):
        output = function(*given)
        if part in ("start", "ask"):
            _ = output[1].population  # has to exist
        elif part == "tell" and not isinstance(output, strategy.state):
            raise TypeError(f"tell must return a {strategy.state.__name__}")
        return output


#: (population, generation, ...) -> a score for each individual, not finite if it failed; also costs
#: for a strategy that searches a front. More arguments, if the candidates have such fields, are:
#: ``machines`` to simulate on; ``needed``, below which a score need not be exact; and ``broken``,
#: the violations that are known without a simulation.
Evaluate = Callable[..., Floats | Scored | Weighed]


class Archive(NamedTuple):
    """The best individual of every tree so far; nothing that was found gets lost."""

    population: Population  # (trees, ...), row t has tree t
    score: Floats  # (trees,), -inf where a tree was never tried or always failed


class History(NamedTuple):
    """Results of each generation."""

    best: Floats  # (generations,) best score so far; nan while all have failed
    #: Median score of the individuals that did not fail; nan if all failed. An individual that was
    #: stopped early counts with the score that it could still have reached.
    median: Floats
    diverged: Integers  # individuals that failed
    structures: Integers  # distinct trees in the generation, or that take turns (cma)


class Search(NamedTuple):
    """Full state of a search, which is also the content of a checkpoint."""

    generation: int  # generations done
    state: State
    archive: Archive
    history: History


def generations(
    searcher: Searcher,
    genome: Genome,
    total: int,
    seed: int,
    evaluate: Evaluate,
    search: Search | None = None,
) -> Iterator[Search]:
    """Search up to ``total`` generations, from the start or from ``search``; yield after each.

    The random numbers of a generation depend only on the seed and the number of the generation, so
    that a continued search has the same bits as an uninterrupted one.
    """
    if search is None:
        untried = Archive(genome.empty(), np.full(genome.structures, -np.inf))
        nothing = History(*np.empty((2, 0)), *np.empty((2, 0), int))
        search = Search(0, None, untried, nothing)
    for generation in range(search.generation, total):
        rng = np.random.default_rng([seed, generation])
        if generation == 0:
            state, candidates = searcher.start(rng)
        else:
            state, candidates = searcher.ask(search.state, generation, rng)
        more = {name: getattr(candidates, name, None) for name in ("machines", "needed", "broken")}
        named = {name: value for name, value in more.items() if value is not None}
        judged = evaluate(candidates.population, generation, **named)
        fitness = judged.fitness if isinstance(judged, Weighed) else judged
        score = judged if isinstance(judged, np.ndarray) else judged.score
        finished = np.isfinite(score)
        score = np.where(finished, score, -np.inf)
        archive = _archived(search.archive, candidates.population, score)
        best = archive.score.max()
        entry = (
            best if np.isfinite(best) else np.nan,
            np.median(score[finished]) if finished.any() else np.nan,
            np.count_nonzero(~finished),
            getattr(candidates, "structures", None) or len(np.unique(candidates.population.tree)),
        )
        history = History(*(np.append(a, b) for a, b in zip(search.history, entry, strict=True)))
        if isinstance(fitness, Scored):
            fitness = fitness._replace(score=score)
        else:
            fitness = np.where(finished, fitness, -np.inf)
        search = Search(generation + 1, searcher.tell(state, candidates, fitness), archive, history)
        yield search


def fault(search: Search, empty: Population, settings: StrategySettings) -> str | None:
    """Return an error in a search from a file, or None; ``empty`` has one individual per tree."""
    generation, state, archive, history = search
    if not 1 <= generation <= settings.generations:
        return f"{generation} generations of {settings.generations}"
    if any(column.shape != (generation,) for column in history) or np.isinf(history.best).any():
        return "its history must have a row for each generation"
    best = archive.score.max()
    if not (archive.score < np.inf).all() or (np.isfinite(best) and history.best[-1] != best):
        return "the scores of its archive are missing, or differ from its history"
    parts = (archive, state, *state)
    scored = [x for x in parts if "population" in getattr(x, "_fields", ())]
    possible = all(_possible(x, empty) for x in scored)
    if not (possible and np.array_equal(archive.population.tree, empty.tree)):
        return "its individuals are impossible"
    known = STRATEGIES.get(settings.preset).sound(settings, state)
    return None if known else "its state does not belong to such a search"


def _possible(scored: State, empty: Population) -> bool:
    """Return True if structures exist, arrays are complete, and those with a score are finite.

    ``scored`` is a record with a ``population``; of its other populations, only trees are checked.
    """
    population, count = scored.population, scored.population.tree.shape
    alive = np.isfinite(getattr(scored, "score", np.full(count, -np.inf)))
    trees = dict(flat(taken(empty, population.tree)))
    others = (x for x in scored if "tree" in getattr(x, "_fields", ()) and x is not population)
    if not all(np.isin(other.tree, empty.tree).all() for other in others):
        return False
    return alive.shape == count and all(
        len(array) == len(alive)
        and (name.rpartition(".")[2] != "tree" or np.array_equal(array, trees[name]))
        and (array.dtype.kind != "f" or np.isfinite(array[alive]).all())
        for name, array in flat(population)
    )


def _archived(archive: Archive, population: Population, score: Floats) -> Archive:
    """Return the best individual of every tree, from the archive or from this generation."""
    both = joined(archive, Archive(population, score))
    tree = both.population.tree
    order = np.lexsort((-both.score, tree))  # stable: on a tie the older one stays
    return taken(both, order[np.unique(tree[order], return_index=True)[1]])
