"""One loop for every strategy: ask, score, tell, remember the best of each structure."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.genome import Genome, Population, joined, taken
from hfc_design.core.shapes import Floats, Integers
from hfc_design.search.strategy import Searcher, State

#: What a population is ranked by, no finite number where an individual failed.
Evaluate = Callable[[Population], Floats]


class Archive(NamedTuple):
    """The best individual ever seen of every tree; nothing that was found gets lost."""

    population: Population  # (trees, ...), row t has tree t
    score: Floats  # (trees,), -inf where a tree was never tried or always failed


class History(NamedTuple):
    """What became of each generation."""

    best: Floats  # (generations,) best score so far; nan while all have failed
    median: Floats  # median score of those in the generation that did not fail; nan without any
    diverged: Integers  # individuals that failed
    structures: Integers  # distinct trees in the generation


class Search(NamedTuple):
    """Everything that a search has to remember; a checkpoint is this and nothing else."""

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
    """Run to ``total`` generations from the start or from ``search``; yields after each.

    The random numbers of a generation depend on the seed and its number alone, so that a
    continued search is the same search, bit for bit.
    """
    if search is None:
        untried = Archive(genome.empty(), np.full(genome.structures, -np.inf))
        search = Search(0, None, untried, _EMPTY_HISTORY)
    for generation in range(search.generation, total):
        rng = np.random.default_rng([seed, generation])
        if generation == 0:
            state, asked = searcher.start(rng)
        else:
            state, asked = searcher.ask(search.state, generation, rng)
        score = evaluate(asked.population)
        finished = np.isfinite(score)
        score = np.where(finished, score, -np.inf)
        archive = _archived(search.archive, asked.population, score)
        best = archive.score.max()
        entry = (
            best if np.isfinite(best) else np.nan,
            np.median(score[finished]) if finished.any() else np.nan,
            np.count_nonzero(~finished),
            len(np.unique(asked.population.tree)),
        )
        history = History(*(np.append(a, b) for a, b in zip(search.history, entry, strict=True)))
        search = Search(generation + 1, searcher.tell(state, asked, score), archive, history)
        yield search


_EMPTY_HISTORY = History(np.empty(0), np.empty(0), np.empty(0, int), np.empty(0, int))


def _archived(archive: Archive, population: Population, score: Floats) -> Archive:
    """The best of every tree, among what the archive holds and this generation."""
    both = joined(archive.population, population)
    scores = np.concatenate([archive.score, score])
    order = np.lexsort((-scores, both.tree))  # stable: on a tie the older one stays
    best = order[np.unique(both.tree[order], return_index=True)[1]]
    return Archive(taken(both, best), scores[best])
