"""Published rule bases and terms of the feed-drive controllers, as data."""

import sys
from collections.abc import Sequence

#: Linguistic labels, negative large to positive large.
LABELS = ("NL", "NM", "NS", "ZR", "PS", "PM", "PL")

#: Rows: term of the error, NL to PL. Columns: term of its change, NL to PL.
RULE_BASES = {
    "I": (  # JK04 Table 1
        "NL NL NL NL NL NL NL",
        "NL NL NM NM NS NS NS",
        "NL NM NM NS NS NS ZR",
        "ZR ZR ZR ZR ZR ZR ZR",
        "ZR PS PS PS PM PM PL",
        "PS PS PS PM PM PL PL",
        "PL PL PL PL PL PL PL",
    ),
    "II": (  # JK04 Table 5: linear but for saturation
        "NL NL NL NL NM NS ZR",
        "NL NL NL NM NS ZR PS",
        "NL NL NM NS ZR PS PM",
        "NL NM NS ZR PS PM PL",
        "NM NS ZR PS PM PL PL",
        "NS ZR PS PM PL PL PL",
        "ZR PS PM PL PL PL PL",
    ),
    "III": (  # JK04 Table 6, after MacVicar-Whelan
        "NL NL NL NL NM NS ZR",
        "NL NL NM NM NS ZR PS",
        "NL NM NS NS ZR PS PM",
        "NM NM NS ZR PS PM PM",
        "NM NS ZR PS PS PM PL",
        "NS ZR PS PM PM PL PL",
        "ZR PS PM PL PL PL PL",
    ),
}

_INFINITE = float("inf")

#: JK04 Table 3: left edge, centre, right edge of each term, in BLU.
ERROR_TERMS = (
    (-_INFINITE, -21.0, -16.0),
    (-19.0, -14.0, -9.0),
    (-12.0, -7.0, -2.0),
    (-5.0, 0.0, 5.0),
    (2.0, 7.0, 12.0),
    (9.0, 14.0, 19.0),
    (16.0, 21.0, _INFINITE),
)
CHANGE_TERMS = (
    (-_INFINITE, -4.5, -3.5),
    (-4.0, -3.0, -2.0),
    (-2.5, -1.5, -0.5),
    (-1.0, 0.0, 1.0),
    (0.5, 1.5, 2.5),
    (2.0, 3.0, 4.0),
    (3.5, 4.5, _INFINITE),
)
#: JK04 Table 3: centroid of each label in units of the command.
CENTROIDS = (-32.0, -16.0, -8.0, 0.0, 8.0, 16.0, 32.0)


def rule_labels(name: str) -> tuple[tuple[str, ...], ...]:
    """Labels (7, 7) of a published rule base, ``I``, ``II`` or ``III``."""
    return tuple(tuple(row.split()) for row in RULE_BASES[name])


def rule_singletons(
    name: str, centroids: tuple[float, ...] = CENTROIDS
) -> tuple[tuple[float, ...], ...]:
    """Singletons (7, 7) of a published rule base with the centroids of NL to PL."""
    return tuple(tuple(centroids[LABELS.index(x)] for x in row) for row in rule_labels(name))


def nearest_labels(table: Sequence[Sequence[float]]) -> list[list[str]]:
    """The label of each singleton whose usual height, in shares of the largest, is nearest."""
    largest = max(*(abs(u) for row in table for u in row), sys.float_info.min)

    def label(singleton: float) -> str:
        share = singleton / largest
        return min(LABELS, key=lambda x: abs(share - CENTROIDS[LABELS.index(x)] / CENTROIDS[-1]))

    return [[label(u) for u in row] for row in table]
