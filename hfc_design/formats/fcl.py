"""Fuzzy Control Language in two dialects: IEC 61131-7, and jFuzzyLogic.

Terms of the standard consist of straight lines or are singletons, so a Gaussian becomes a polygon.
jFuzzyLogic has a Gaussian term, GAUSS2. Triangles are exact in both dialects.
"""

import math
from functools import partial

import numpy as np

from hfc_design.codegen.st import literal_of
from hfc_design.controllers.rules import FlatGaussian, Term
from hfc_design.formats.fuzzy_files import Input, texts
from hfc_design.formats.writing import Format

#: Number of straight lines on either side of a Gaussian.
LINES = 64

STANDARD = [
    "Fuzzy Control Language, standard dialect (IEC 61131-7:2000).",
    "Terms are straight lines between points, constant beyond the first and the last.",
    f"A Gaussian has {LINES} lines a side: a unit is right to 1e-3 of its largest output.",
]
JFUZZYLOGIC = [
    "Fuzzy Control Language, dialect of jFuzzyLogic: GAUSS2, ACCU : SUM and its place are not",
    "those of IEC 61131-7:2000.",
]


def gauss2(term: Term, place: Input) -> str:
    """Return a Gaussian term as GAUSS2 with two means and widths, a triangle as its points."""
    if not isinstance(term, FlatGaussian):
        return polygon(term, place)
    return "GAUSS2 " + " ".join(map(literal_of, (term.low, term.sigma, term.high, term.sigma)))


def polygon(term: Term, place: Input) -> str:
    """Return the points (x, degree) of a term as text, within the range of its input."""
    if isinstance(term, FlatGaussian):
        left = _tail(term.sigma, term.low, place.lowest, -1.0)
        right = _tail(term.sigma, term.high, place.highest, 1.0)
        flat = [(term.low, 1.0), (term.high, 1.0)] if term.low < term.high else [(term.low, 1.0)]
        points = [*reversed(left), *flat, *right]
    else:
        corners = [(term.left, 0.0), (term.centre, 1.0), (term.right, 0.0)]
        points = [point for point in corners if math.isfinite(point[0])]
    return " ".join(f"({literal_of(x)}, {literal_of(y)})" for x, y in points)


def _tail(sigma: float, shoulder: float, end: float, side: float) -> list[tuple[float, float]]:
    """Return points (x, degree) from a ``shoulder``, where the degree begins to fall, to ``end``.

    They lie on the given ``side`` of the shoulder, -1 or 1. An output is a quotient of degrees, so
    small degrees need small relative errors where no other term is near. A factor degree^(1/2) in
    the density of points would equalise the absolute errors of all lines, a factor degree^0 their
    relative errors; degree^0.35 is a compromise.
    """
    width = min(side * (end - shoulder), 39.0 * sigma)  # beyond 39 sigma it is 0 in floats
    if width <= 0.0:
        return []
    d = np.linspace(0.0, width, 4001)
    degree = np.exp(-0.5 * (d / sigma) ** 2)
    density = np.sqrt(1.0 + (d / sigma) ** 2) * degree**0.35
    share = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    places = np.interp(np.linspace(0.0, share[-1], LINES + 1), share, d)[1:]
    points = {shoulder + side * float(x): math.exp(-0.5 * (float(x) / sigma) ** 2) for x in places}
    points.pop(shoulder, None)  # a very narrow term: x rounds to the shoulder
    return list(points.items()) or [(math.nextafter(shoulder, side * math.inf), 0.0)]


TEXT = "a folder with Fuzzy Control Language of IEC 61131-7, one block per unit"
DIALECT = "the same in the dialect of jFuzzyLogic"
_standard = partial(texts, target="fcl", about=STANDARD, real=literal_of, shape=polygon)
_dialect = partial(
    texts, target="fcl-jfuzzylogic", about=JFUZZYLOGIC, real=literal_of, shape=gauss2
)
FORMATS = (Format("fcl", TEXT, _standard), Format("fcl-jfuzzylogic", DIALECT, _dialect))
