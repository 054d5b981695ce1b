"""Non-dominated sorting and crowding: the designs of many than which no other is better.

Deb, Pratap, Agarwal and Meyarivan, IEEE Trans. Evolutionary Computation 6(2), 2002: section III A
and B, and constrained domination of section VI. Lower costs are better.
"""

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Indices, Integers, Mask

#: Individuals that are compared with all others at once; a row of truths for each.
BLOCK = 256


def dominated(costs: Floats, by: Floats) -> Mask:
    """(n,) whether any of ``by`` (k, m) is nowhere worse than one of ``costs`` (n, m), and better.

    Equal points do not dominate one another.
    """
    is_dominated = np.zeros(len(costs), bool)
    for start in range(0, len(costs), BLOCK):
        block = costs[start : start + BLOCK, None]
        better = (by <= block).all(axis=2) & (by < block).any(axis=2)
        is_dominated[start : start + BLOCK] = np.any(better, axis=1)
    return is_dominated


def front_numbers(costs: Floats, violation: Floats) -> Integers:
    """(n,) 0 for points that none dominates, 1 for points dominated only by these, and so on.

    A point that breaks no constraint (``violation`` 0) comes before all that do, and among these
    the one that breaks less; an infinite violation is a failed loop.
    """
    numbers = np.zeros(len(costs), np.int64)
    left, number = np.flatnonzero(violation == 0.0), 0
    while len(left):
        lost = dominated(costs[left], costs[left])
        numbers[left[~lost]] = number
        left, number = left[lost], number + 1
    broken = violation > 0.0
    numbers[broken] = number + np.unique(violation[broken], return_inverse=True)[1]
    return numbers


def crowding(costs: Floats) -> Floats:
    """(n,) distance between the neighbours of each point on one front, infinite at its ends.

    It is the sum over the costs, each as a share of the front's width; of equal points all but the
    first have 0.
    """
    distances = np.zeros(len(costs))
    _, first = np.unique(costs, axis=0, return_index=True)
    first = np.sort(first)
    if len(first) <= 2:
        distances[first] = np.inf
        return distances
    points = costs[first]
    for column in points.T:
        order = np.argsort(column, kind="stable")
        width = column[order[-1]] - column[order[0]]
        if not width > 0.0:
            continue
        distances[first[order[1:-1]]] += (column[order[2:]] - column[order[:-2]]) / width
        distances[first[order[[0, -1]]]] = np.inf
    return distances


def best_first(costs: Floats, violation: Floats) -> Indices:
    """(n,) order of preference: by front, within a front the less crowded first."""
    front, apart = front_numbers(costs, violation), np.zeros(len(costs))
    for number in np.unique(front):
        members = front == number
        apart[members] = crowding(costs[members])
    return np.lexsort((-apart, front))


def spread_out(costs: Floats, most: int) -> Indices:
    """At most ``most`` points of a front, in their order; the least important go one by one."""
    survivors = np.arange(len(costs))
    while len(survivors) > most:
        survivors = np.delete(survivors, int(np.argmin(share(costs[survivors]))))
    return survivors


def share(costs: Floats) -> Floats:
    """(n,) importance of each point of a front, infinite for the best in each cost.

    With two costs it is the area that the point alone dominates: the loss of hypervolume without it
    (Beume, Naujoks and Emmerich, European J. Operational Research 181, 2007). With three this takes
    too long, and it is the product of the distances to its three neighbours (Kukkonen and Deb, PPSN
    IX, 2006).
    """
    points = scaled(costs)
    if points.shape[1] == 2:
        shares = np.full(len(points), np.inf)
        order = np.argsort(points[:, 0], kind="stable")
        gaps = np.abs(np.diff(points[order], axis=0))
        shares[order[1:-1]] = gaps[1:, 0] * gaps[:-1, 1]
        return shares
    away = np.abs(points[:, None] - points).sum(axis=2)
    np.fill_diagonal(away, np.inf)
    shares = np.sort(away, axis=1)[:, : points.shape[1]].prod(axis=1)
    shares[points.argmin(axis=0)] = np.inf
    return np.asarray(shares)


def knee(costs: Floats) -> int:
    """Point of a front (n, m) that bends most: a little less of one cost takes much of another.

    It is the farthest below the line, or plane, through the ends of the front, each cost scaled
    from 0 at its best to 1 at its worst (Das, Structural Optimization 18, 1999). If several points
    bend equally, as on a straight front, it is the first.
    """
    total = scaled(costs).sum(axis=1)
    return int(np.argmax(total <= total.min() + SAME))


def scaled(costs: Floats) -> Floats:
    """(n, m) each cost from 0 at its best to 1 at its worst on the front, 0 if all are equal."""
    low, high = costs.min(axis=0), costs.max(axis=0)
    return np.asarray((costs - low) / np.where(high > low, high - low, 1.0))
