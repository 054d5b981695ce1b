"""Non-dominated sorting and crowding: ranking of designs by several costs at once.

Deb, Pratap, Agarwal and Meyarivan, IEEE Trans. Evolutionary Computation 6(2), 2002: section III A
and B, and constrained domination of section VI. Lower costs are better.
"""

import numpy as np

from hfc_design.core.numbers import SAME, Floats, Indices, Integers, Mask

#: Number of points that are compared with all others at once, which limits the memory.
BLOCK = 256


def dominated(costs: Floats, by: Floats) -> Mask:
    """Return True for each point of ``costs`` (n, m) that a point of ``by`` (k, m) dominates, (n,).

    A point dominates another if none of its costs is higher, and at least one is lower.
    """
    is_dominated = np.zeros(len(costs), bool)
    for start in range(0, len(costs), BLOCK):
        block = costs[start : start + BLOCK, None]
        better = (by <= block).all(axis=2) & (by < block).any(axis=2)
        is_dominated[start : start + BLOCK] = np.any(better, axis=1)
    return is_dominated


def front_numbers(costs: Floats, violation: Floats) -> Integers:
    """Return front numbers, (n,): 0 if no point dominates, 1 if only points with 0 do, and so on.

    Points that violate a constraint (``violation`` above 0; infinite: the loop failed) come after
    all others, the smallest violation first.
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
    """Return the distance between the neighbours of each point of a front, (n,).

    The distance is summed over the costs, each as a share of the front's width. It is infinite for
    the ends of the front. Of several equal points, all but the first have 0.
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
    """Return the indices of points in order, (n,): by front, in a front the less crowded first."""
    front, apart = front_numbers(costs, violation), np.zeros(len(costs))
    for number in np.unique(front):
        members = front == number
        apart[members] = crowding(costs[members])
    return np.lexsort((-apart, front))


def spread_out(costs: Floats, most: int) -> Indices:
    """Return the indices of up to ``most`` points; the least important are removed one by one."""
    survivors = np.arange(len(costs))
    while len(survivors) > most:
        survivors = np.delete(survivors, int(np.argmin(share(costs[survivors]))))
    return survivors


def share(costs: Floats) -> Floats:
    """Return the importance of each point of a front, (n,); infinite for the best in each cost.

    With two costs, it is the area that only this point dominates (its share of the hypervolume:
    Beume, Naujoks and Emmerich, European J. Operational Research 181, 2007). With three costs, this
    takes too long; then it is the product of the distances to the three nearest points (Kukkonen
    and Deb, PPSN IX, 2006).
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
    """Return the index of the knee of a front (n, m), where the front bends most.

    The knee is the point farthest below the line (or plane) through the ends of the front, with
    each cost scaled from 0 (best) to 1 (worst) (Das, Structural Optimization 18, 1999). If several
    points are equally far, as on a straight front, it is the first of them.
    """
    total = scaled(costs).sum(axis=1)
    return int(np.argmax(total <= total.min() + SAME))


def scaled(costs: Floats) -> Floats:
    """Return costs (n, m) scaled from 0 (best of the front) to 1 (worst); 0 if all are equal."""
    low, high = costs.min(axis=0), costs.max(axis=0)
    return np.asarray((costs - low) / np.where(high > low, high - low, 1.0))
