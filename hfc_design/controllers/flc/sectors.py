"""What keeps a rule table inside the stable range (JK04 section 3). Never imports JAX."""

from typing import NamedTuple

from hfc_design.core.scalars import Xp, clipped
from hfc_design.core.shapes import RuleTable, Scalar, Triangles

ZR = 3  # place of the middle term


class Sectors(NamedTuple):
    """The rectangle in the stable range that the table may not leave (JK04 eq. 12-14)."""

    k1_max: Scalar  # 0 <= u_1 / e <= k1_max [units/BLU]
    k2_max: Scalar  # 0 <= u_2 / de <= k2_max [units/BLU]


def bounded(
    xp: Xp,
    sectors: Sectors,
    error_terms: Triangles,
    change_terms: Triangles,
    singletons: RuleTable,
    signs: RuleTable,
) -> list[list[Scalar]]:
    """Singletons (7, 7) moved to the nearest values that keep the table in ``sectors``.

    A singleton is the whole output from the inner neighbour's edge outwards, so this is where its
    slope is steepest; between two such points the product rule stays under the chord. The column
    de = ZR makes u_1, the other columns less this one make u_2 (JK04 eq. 13, 14). No singleton
    takes another sign than in ``signs`` (7, 7), unless its sector demands it; one that is 0 there
    may take the sign of its row. The row e = ZR stays.
    """
    table = []
    for i, row in enumerate(singletons):
        if i == ZR:
            table.append(list(row))
            continue
        reach = sectors.k1_max * (error_terms[i - 1][2] if i > ZR else error_terms[i + 1][0])
        low, high = (0.0, reach) if i > ZR else (reach, 0.0)
        own = xp.once(clipped(xp, row[ZR], low, high))
        bound = []
        for j, singleton in enumerate(row):
            if j == ZR:
                bound.append(own)
                continue
            positive = signs[i][j] >= 0.0 if i > ZR else signs[i][j] > 0.0
            kept = xp.where(positive, xp.maximum(singleton, 0.0), xp.minimum(singleton, 0.0))
            reach = sectors.k2_max * (change_terms[j - 1][2] if j > ZR else change_terms[j + 1][0])
            low, high = (own, own + reach) if j > ZR else (own + reach, own)
            bound.append(clipped(xp, kept, low, high))
        table.append(bound)
    return table
