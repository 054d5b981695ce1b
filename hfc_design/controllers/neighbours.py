"""Degrees of a value in fuzzy terms of which at most two neighbours fire.

Code that may branch on values (``Xp.sparse``: the runtime, code in other languages) computes only
the degrees of these two terms. The simulator, which steps a population at once, computes those of
all terms. The text of a law is the same for both. Never imports JAX.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeAlias

from hfc_design.core.numbers import Scalar, Triangles, Xp, clipped, total


class Neighbours(NamedTuple):
    """Two neighbouring terms with a number for each, such as its degree."""

    first: Scalar  # index of the lower term, from 0 on
    values: Sequence[Scalar]  # (2,) numbers of the lower and of the upper term


#: Degrees of a value in the terms of an input: in all terms, or in the two that may fire.
Degrees: TypeAlias = "Sequence[Scalar] | Neighbours"


class Partition(NamedTuple):
    """Triangular terms in order, which overlap; the outermost terms are 1 beyond their centres."""

    centres: Sequence[Scalar]  # (n,)
    #: (n - 1,) right edge of each term but the last, not beyond the centre of the next term.
    rights: Sequence[Scalar]
    lefts: Sequence[Scalar]  # (n - 1,) left edge of each term but the first, likewise

    @classmethod
    def of(cls, triangles: Triangles) -> "Partition":
        """Return the partition of triangles (left, centre, right); outermost edges are ignored."""
        centres = [centre for _, centre, _ in triangles]
        rights = [right for _, _, right in triangles[:-1]]
        return cls(centres, rights, [left for left, _, _ in triangles[1:]])

    def triangles(self) -> tuple[tuple[Scalar, Scalar, Scalar], ...]:
        """Return (n, 3) left edge, centre, right edge of each term; the outermost are infinite."""
        lefts, rights = [-math.inf, *self.lefts], [*self.rights, math.inf]
        return tuple(zip(lefts, self.centres, rights, strict=True))


def memberships(xp: Xp, terms: Partition, u: Scalar) -> Degrees:
    """Degrees of ``u`` in triangles (JK04 eq. 1). A degree is 0 on an edge."""
    if not xp.sparse:
        return [_membership(xp, terms, k, u) for k in range(len(terms.centres))]
    degrees: Degrees = xp.call(neighbours, xp, *map(xp.table, terms), u)
    return degrees


def neighbours(
    xp: Xp, centres: Sequence[Scalar], rights: Sequence[Scalar], lefts: Sequence[Scalar], u: Scalar
) -> Neighbours:
    """Return the two terms of a ``Partition`` that may fire at the value ``u``, with degrees."""
    k = sum((u >= centre for centre in centres[1:-1]), 0)
    right, left = rights[k], lefts[k]
    lower = clipped(xp, (right - u) / (right - centres[k]), 0.0, 1.0)
    upper = clipped(xp, (u - left) / (centres[k + 1] - left), 0.0, 1.0)
    return Neighbours(k, (lower, upper))


def _membership(xp: Xp, terms: Partition, k: int, u: Scalar) -> Scalar:
    degree: Scalar = 1.0
    if k > 0:
        left = terms.lefts[k - 1]
        degree = xp.minimum(degree, (u - left) / (terms.centres[k] - left))
    if k < len(terms.centres) - 1:
        right = terms.rights[k]
        degree = xp.minimum(degree, (right - u) / (right - terms.centres[k]))
    return xp.maximum(degree, 0.0)


def evenly(xp: Xp, place: Scalar, highest: int) -> Degrees:
    """Return the degrees of ``place`` in triangles with centres at -``highest`` to ``highest``.

    Centres are 1 apart. Triangles end at their neighbours' centres, so the degrees add up to 1.
    """

    if not xp.sparse:
        return [_near(xp, place, k) for k in range(-highest, highest + 1)]
    degrees: Degrees = xp.call(even_neighbours, xp, place, highest)
    return degrees


def even_neighbours(xp: Xp, place: Scalar, highest: int) -> Neighbours:
    """Return the two terms of ``evenly`` that may fire, with degrees."""
    last = 2 * highest - 1
    k = xp.minimum(xp.whole(place + float(highest)), last)
    degrees = _near(xp, place, k - highest), _near(xp, place, k - (highest - 1))
    return Neighbours(k, degrees)


def _near(xp: Xp, place: Scalar, term: Scalar) -> Scalar:
    return xp.once(xp.maximum(1.0 - abs(place - term), 0.0))


def fired(degrees: Degrees) -> Iterable[tuple[Scalar, Scalar]]:
    """Return index and degree of each term in ``degrees``, thus of every term that fires."""
    if isinstance(degrees, Neighbours):
        lower, upper = degrees.values
        return [(degrees.first, lower), (degrees.first + 1, upper)]
    return enumerate(degrees)


def spread(degrees: Degrees, count: int) -> Sequence[Scalar]:
    """Return the degree of each of ``count`` terms, 0 for terms that ``degrees`` leaves out."""
    if not isinstance(degrees, Neighbours):
        return degrees
    values = [0.0] * count
    values[degrees.first : degrees.first + 2] = degrees.values
    return values


def firing_of(degrees: Degrees) -> Scalar:
    """Return the sum of all degrees."""
    return total(degree for _, degree in fired(degrees))


def alike(degrees: Degrees, values: Sequence[Scalar]) -> Degrees:
    """Return ``values``, one for each term in ``degrees``, in the same form as ``degrees``."""
    return Neighbours(degrees.first, values) if isinstance(degrees, Neighbours) else values


def number_of(xp: Xp, values: Degrees, k: Scalar) -> Scalar:
    """Return the value of the term with index ``k``; 0 if ``values`` leaves it out."""
    if not isinstance(values, Neighbours):
        return values[k]
    lower, upper = values.values
    upper_value = xp.where(k == values.first + 1, upper, 0)
    return xp.where(k == values.first, lower, upper_value)


def weighted(xp: Xp, in_row: Degrees, in_column: Degrees, table: Any) -> Scalar:
    """Return the sum of a table's numbers, each times the degrees of its row and its column."""
    rows = xp.table(table) if xp.sparse else table
    return xp.total(
        row * xp.total(column * rows[i][j] for j, column in fired(in_column))
        for i, row in fired(in_row)
    )


def changed(
    xp: Xp,
    in_row: Degrees,
    in_column: Degrees,
    table: Any,
    of_row: Callable[[Scalar], Scalar],
    function: Callable[..., Scalar],
) -> Any:
    """A table whose numbers are changed if both their row and their column fire.

    ``function`` computes the new number from three values: ``of_row`` of the degree of its row, the
    degree of its column, and the old number. It must not change a number whose row or column does
    not fire.
    """
    if not xp.sparse:
        sizes = map(of_row, in_row)
        return [
            [function(size, *each) for each in zip(in_column, row, strict=True)]
            for size, row in zip(sizes, table, strict=True)
        ]
    row_sizes = [(i, of_row(degree)) for i, degree in fired(in_row)]
    columns, rows = [*fired(in_column)], xp.table(table)
    each = ((i, size, j, degree) for i, size in row_sizes for j, degree in columns)
    return xp.put(table, [(i, j, function(size, d, rows[i][j])) for i, size, j, d in each])
