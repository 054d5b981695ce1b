"""What Jee & Koren 2004 (JK04) print: machines, terms, rule bases, and closed forms of a table."""

import numpy as np

from hfc_design.controllers.flc.rules import CENTROIDS, LABELS
from hfc_design.core.records import TERMS
from plants.feed_drive import FeedDriveParameters

FRICTION = (
    "coulomb",
    "stiction_rise",
    *(f"positive_{part}" for part in ("start", "slope", "curvature")),
    *(f"negative_{part}" for part in ("start", "slope", "curvature")),
)


def without_friction(p):
    """The same axis without any friction: JK04 eq. 18 alone."""
    return p._replace(**dict.fromkeys(FRICTION, 0.0))


_X = FeedDriveParameters()
_Y = _X._replace(
    positive_start=7.23,
    positive_slope=-1.12,
    positive_curvature=0.04,
    negative_start=-5.04,
    negative_slope=-0.68,
    negative_curvature=-0.02,
)
#: JK04 prints no F_c. "coulomb" has the printed K = 28.3 and gives the PID's contour errors of Fig.
#: 12, and with doubled singletons those of the fuzzy controllers; "start" has only the nonlinear
#: part of the friction and, with K = 40, gives the FLC's axial error of Fig. 10 with the printed
#: singletons (with K = 28.3 the largest, 32 units, cannot keep up with that circle's 44).
PARAMETER_SETS = {
    "x-coulomb": _X,
    "y-coulomb": _Y,
    "x-start": _X._replace(gain=40.0, coulomb=0.0),
    "y-start": _Y._replace(gain=40.0, coulomb=0.0),
    "frictionless": without_friction(_X),
}
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


def rule_labels(name):
    """Labels (7, 7) of a published rule base, ``I``, ``II`` or ``III``."""
    return tuple(tuple(row.split()) for row in RULE_BASES[name])


def rule_singletons(name, centroids=CENTROIDS):
    """Singletons (7, 7) of a published rule base with the centroids of NL to PL."""
    return tuple(tuple(centroids[LABELS.index(x)] for x in row) for row in rule_labels(name))


def confined(found):
    """Whether no gain of sectors is negative, as the stability theorem asks."""
    return found.k1_low >= 0.0 and found.k2_low >= 0.0


def k2_of_rule_base_1(small, medium, large, spacing):
    """K_2 [unit/BLU] of rule base I from its positive centroids U_1, U_2, U_3 (JK04 eq. 23).

    ``spacing`` is the distance beta of the centres of the change of error [BLU], evenly spaced.
    """
    if 3.0 * medium - 2.0 * small - large >= 0.0:
        steepest, ahead = (medium - small) / spacing, 3.0 * medium - 4.0 * small
    else:
        steepest = (large - medium) / (2.0 * spacing)
        ahead = 3.0 * large - 3.0 * medium - 2.0 * small
    return steepest if ahead >= 0.0 else small / (3.0 * spacing)


def bilinear(error_centres, change_centres, singletons, error, change):
    """The command where every edge meets the neighbour's centre: JK04 eq. 7 with its cross term.

    With s, t in [0, 1] the place between two centres of e and of de, the four rules fire at
    (1 - s)(1 - t), s(1 - t), (1 - s)t, st. Printed are the terms without s t, which alone give
    U_{i+1,j} + U_{i,j+1} - U_{i,j} instead of U_{i+1,j+1} at s = t = 1.
    """
    i, s = _place(error_centres, error)
    j, t = _place(change_centres, change)
    (low, right), (up, across) = np.asarray(singletons)[i : i + 2, j : j + 2]
    cross = (across - up - right + low) * s * t
    return float(low + (up - low) * s + (right - low) * t + cross)


def _place(centres, value):
    """The piece that ``value`` lies in, and where in it; outside, the nearest end."""
    k = int(np.clip(np.searchsorted(centres, value) - 1, 0, TERMS - 2))
    return k, float(np.clip((value - centres[k]) / (centres[k + 1] - centres[k]), 0.0, 1.0))
