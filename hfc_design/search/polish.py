"""Last steps of a search: improve the rank of one individual, whose structure stays.

A step proposes many individuals at once, by Gauss-Newton with many dampings or, if these fail, from
a distribution that moves towards good samples; the simulator decides. A proposal is accepted only
if it is better in the complete ranking, so that a polish never ends worse than it began.
"""

from collections.abc import Callable, Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from hfc_design.controllers.genome import Genome, Population, joined, taken
from hfc_design.core.numbers import Floats, Integers, Mask
from hfc_design.search.coordinates import Coordinates, chain, coordinates
from hfc_design.search.distribution import Distribution, begun, drawn, learnt
from hfc_design.search.newton import damped

#: Lengths that are tried, as multiples of a whole Gauss-Newton step. Reweighted least squares are
#: an upper bound of the sum of magnitudes, so that a whole step is too short.
LENGTHS = (4.0, 2.0, 1.0)
#: Share of the numbers that half of the proposals leave unchanged: a kink then stops only some.
LEFT_OUT = 0.5
#: Dampings range over so many decades to either side of the last successful one.
DECADES = 3.0
#: First damping, its factor after a failed step, and the damping above which steps become blind.
FIRST_DAMPING, FAILURE, HOPELESS = 1.0, 3.0, 1e4
#: Number of blind steps (without derivatives) before derivatives are tried again.
BLIND = 10
#: Part of the seed of a polish; larger than the number of any generation.
POLISH = 2**31


class Quadratic(NamedTuple):
    """Normal equations of a weighted least squares problem in the numbers of the gains."""

    normal: Floats  # (ways, gains, gains), a matrix for each way to weigh the residuals
    slope: Floats  # (gains,) half the derivative of the weighted sum of squares


class Polishable(NamedTuple):
    """Interface of a problem that can be polished."""

    genome: Genome
    #: individuals -> (n, 1 or more) numbers that rank them, larger is better; -inf: it failed.
    worth: Callable[[Population], Floats]
    #: (individuals, random generator) -> (n,) estimates of ``worth`` on fewer machines; only those
    #: of the same call can be compared.
    screened: Callable[[Population, np.random.Generator], Floats]
    #: (population of one, random generator) -> normal equations; the result is None if they are not
    #: finite. None if the machine has no such derivatives.
    quadratic: Callable[[Population, np.random.Generator], Quadratic | None] | None = None
    proposed: int = 127  # number of individuals that a step proposes
    judged: int = 4  # number of these whose ``worth`` is computed


class Polished(NamedTuple):
    """State of a polish, which is also the content of its checkpoint."""

    step: int  # steps done
    population: Population  # (1,) the best so far
    worth: Floats  # (1, 1 or more) worth of the best so far
    first: Floats  # (1, 1 or more) worth of the individual with which the polish began
    damping: float  # of the next Gauss-Newton step
    blind: int  # remaining blind steps (without derivatives); 0: derivatives are tried
    about: Population  # (1,) where the coordinates of the distribution are 0
    distribution: Distribution


def polish(
    task: Polishable, individual: Population, total: int, seed: int, done: Polished | None = None
) -> Iterator[Polished]:
    """Polish a population of one, from the start or from ``done``; yields after each step.

    The random numbers of a step depend only on the seed and the number of the step.
    """
    if done is None:
        done = _begun(task, individual)
    for step in range(done.step, total):
        rng = np.random.default_rng([seed, POLISH, step])
        derived = None
        if task.quadratic is not None and not done.blind:
            derived = task.quadratic(done.population, rng)
        if derived is None and not done.blind:
            done = _begun_blind(task, done)
        done = _blind(task, done, rng) if derived is None else _newton(task, done, derived, rng)
        done = done._replace(step=step + 1)
        yield done


def _begun(task: Polishable, individual: Population) -> Polished:
    worth, chart = task.worth(individual), _coordinates(task, individual)
    nothing = begun(np.zeros(chart.size), chart.step)
    return Polished(0, individual, worth, worth, FIRST_DAMPING, 0, individual, nothing)


def _coordinates(task: Polishable, about: Population) -> Coordinates:
    chart = coordinates(task.genome, about)
    assert chart is not None  # ``check_polish`` has refused others
    return chart


def _newton(
    task: Polishable, done: Polished, derived: Quadratic, rng: np.random.Generator
) -> Polished:
    """Take a Gauss-Newton step; coordinates at a bound that they would leave are held fixed."""
    here = _coordinates(task, done.population)
    slope = chain(task.genome, here)
    normal = np.stack([slope.T @ one @ slope for one in derived.normal])
    quadratic = Quadratic(normal, slope.T @ derived.slope)
    low, high = here.room
    stuck = ((low >= 0.0) & (quadratic.slope > 0.0)) | ((high <= 0.0) & (quadratic.slope < 0.0))
    points, dampings = proposals(quadratic, stuck, done.damping, task.proposed, rng)
    members = here.members(np.clip(points, low, high))
    place, after, _ = _tried(task, done, members, rng)
    if place is not None:
        return after._replace(damping=float(dampings[place]))
    damping = FAILURE * done.damping
    return done._replace(damping=damping) if damping <= HOPELESS else _begun_blind(task, done)


def proposals(
    quadratic: Quadratic, frozen: Mask, damping: float, count: int, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Return points (count, parameters) around 0, and the damping of each (count,).

    Half of the points leave a share ``LEFT_OUT`` of the parameters unchanged.
    """
    rounds = 2 * len(quadratic.normal) * len(LENGTHS)
    each = -(-count // rounds)
    dampings = damping * 10.0 ** np.linspace(-DECADES, DECADES, each)
    some = frozen | (rng.random(len(frozen)) < LEFT_OUT)
    with threadpool_limits(1, user_api="blas"):
        pairs = product(quadratic.normal, (frozen, some))
        steps = [damped(one, quadratic.slope, fixed, dampings) for one, fixed in pairs]
    points = np.concatenate([length * step for step in steps for length in LENGTHS])
    return points[:count], np.tile(dampings, rounds)[:count]


def _begun_blind(task: Polishable, done: Polished) -> Polished:
    """Begin blind steps, with a new distribution around the present individual."""
    one = done.population
    chart = _coordinates(task, one)
    fresh = begun(np.zeros(chart.size), chart.step)
    return done._replace(damping=FIRST_DAMPING, blind=BLIND, about=one, distribution=fresh)


def _blind(task: Polishable, done: Polished, rng: np.random.Generator) -> Polished:
    """Take a blind step, which proposes samples of the distribution and its mean."""
    points = drawn(done.distribution, task.proposed - 1, rng)
    points = np.concatenate([points, done.distribution.mean[None]])
    members = _coordinates(task, done.about).members(points)
    _, after, screened = _tried(task, done, members, rng)
    distribution = learnt(done.distribution, points[:-1], screened[1:-1])
    # If there are no derivatives at all, every step is blind.
    left = done.blind - 1 if task.quadratic is not None else done.blind
    return after._replace(distribution=distribution, blind=left)


def _tried(
    task: Polishable, done: Polished, members: Population, rng: np.random.Generator
) -> tuple[int | None, Polished, Floats]:
    """Return the index of a member that is better than the present one, or None; and the state.

    The last result are screening values (1 + n,) of the present individual and of ``members``.
    """
    screened = task.screened(joined(done.population, members), rng)
    order: Integers = np.argsort(-screened[1:], kind="stable")[: task.judged]
    order = order[screened[1:][order] > screened[0]]
    if not len(order):
        return None, done, screened
    worth = task.worth(taken(members, order))
    better = (worth >= done.worth).all(axis=1) & (worth > done.worth).any(axis=1)
    if not better.any():
        return None, done, screened
    k = int(np.where(better, worth.min(axis=1), -np.inf).argmax())
    after = done._replace(population=taken(members, order[k : k + 1]), worth=worth[k : k + 1])
    return int(order[k]), after, screened
