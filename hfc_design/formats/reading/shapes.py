"""Shapes of terms of other programs, whatever they are called there: degrees of values.

Numbers are in the order of the language that names the shape. Vectorised, NumPy.
"""

from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats


class Curve(NamedTuple):
    """A shape: its degree, and which of its numbers are places on the axis (the others: widths)."""

    degree: Callable[..., Floats]  # (values, *numbers) -> degrees
    needs: int
    places: Sequence[int]
    falls: bool = False  # places need not rise
    reaches: bool = False  # its first and last place may be infinite


def _rising(x: Floats, a: float, b: float) -> Floats:
    """From 0 at a to 1 at b, straight; a step at b where they are one."""
    if a == -inf:
        return np.ones_like(x)
    return np.asarray(np.clip((x - a) / (b - a), 0.0, 1.0) if b > a else (x >= b) * 1.0)


def _falling(x: Floats, a: float, b: float) -> Floats:
    return _rising(-x, -b, -a)


def _trapezoid(x: Floats, a: float, b: float, c: float, d: float) -> Floats:
    return np.minimum(_rising(x, a, b), _falling(x, c, d))


def _ramp(x: Floats, a: float, b: float) -> Floats:
    """fuzzylite's: it rises from a to b, or falls from a to b where b is the lower."""
    return _rising(x, a, b) if a <= b else _falling(x, b, a)


def _gaussian(x: Floats, centre: float, sigma: float) -> Floats:
    return np.exp(-0.5 * ((x - centre) / sigma) ** 2)


def _two_gaussians(x: Floats, left: float, a: float, right: float, b: float) -> Floats:
    """The product of a half that rises to ``left`` and one that falls from ``right``."""
    rising = np.where(x < left, _gaussian(x, left, a), 1.0)
    return rising * np.where(x > right, _gaussian(x, right, b), 1.0)


def _bell(x: Floats, centre: float, width: float, slope: float) -> Floats:
    with np.errstate(over="ignore", divide="ignore"):
        return 1.0 / (1.0 + np.abs((x - centre) / width) ** (2.0 * slope))


def sigmoid(x: Floats, inflection: float, slope: float) -> Floats:
    """From 0 to 1, or the other way where the slope is negative."""
    with np.errstate(over="ignore"):
        return 1.0 / (1.0 + np.exp(-slope * (x - inflection)))


def _s(x: Floats, a: float, b: float) -> Floats:
    """Two parabolas from 0 at a to 1 at b."""
    share = np.where(x > a, _rising(x, a, b), 0.0)
    return np.where(share < 0.5, 2.0 * share**2, 1.0 - 2.0 * (1.0 - share) ** 2)


def _z(x: Floats, a: float, b: float) -> Floats:
    return np.where(x > a, _s(-x, -b, -a), 1.0)


def _pi(x: Floats, a: float, b: float, c: float, d: float) -> Floats:
    return np.minimum(_s(x, a, b), _z(x, c, d))


#: Of .fis, MATLAB's and Octave's.
FIS = {
    "trimf": Curve(lambda x, a, b, c: _trapezoid(x, a, b, b, c), 3, (0, 1, 2), reaches=True),
    "trapmf": Curve(_trapezoid, 4, (0, 1, 2, 3), reaches=True),
    "linsmf": Curve(_rising, 2, (0, 1)),
    "linzmf": Curve(_falling, 2, (0, 1)),
    "gaussmf": Curve(lambda x, s, c: _gaussian(x, c, s), 2, (1,)),
    "gauss2mf": Curve(lambda x, s, c, r, d: _two_gaussians(x, c, s, d, r), 4, (1, 3)),
    "gbellmf": Curve(lambda x, a, b, c: _bell(x, c, a, b), 3, (2,)),
    "sigmf": Curve(lambda x, a, c: sigmoid(x, c, a), 2, (1,)),
    "dsigmf": Curve(
        lambda x, a, c, b, d: np.abs(sigmoid(x, c, a) - sigmoid(x, d, b)), 4, (1, 3), falls=True
    ),
    "psigmf": Curve(
        lambda x, a, c, b, d: sigmoid(x, c, a) * sigmoid(x, d, b), 4, (1, 3), falls=True
    ),
    "smf": Curve(_s, 2, (0, 1)),
    "zmf": Curve(_z, 2, (0, 1)),
    "pimf": Curve(_pi, 4, (0, 1, 2, 3)),
}
#: Of FLL.
FLL = {
    "Triangle": FIS["trimf"],
    "Trapezoid": FIS["trapmf"],
    "Rectangle": Curve(lambda x, a, b: _trapezoid(x, a, a, b, b), 2, (0, 1), reaches=True),
    "Ramp": Curve(_ramp, 2, (0, 1), falls=True),
    "Gaussian": Curve(_gaussian, 2, (0,)),
    "GaussianProduct": Curve(_two_gaussians, 4, (0, 2)),
    "Bell": Curve(_bell, 3, (0,)),
    "Sigmoid": Curve(sigmoid, 2, (0,)),
    "SShape": FIS["smf"],
    "ZShape": FIS["zmf"],
    "PiShape": FIS["pimf"],
}
