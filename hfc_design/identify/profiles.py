"""Profiles of the least certain parameters: how good their intervals are.

A profile shows how much worse the fit becomes if one parameter is set to other values and the rest
is fitted again at each (profile likelihood; Raue et al., Bioinformatics 25, 2009). The intervals
assume a parabola. A curve that is flat on one side bounds the parameter on the other side only.
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from hfc_design.core.numbers import Floats, digits
from hfc_design.identify.fit import VAGUE, Fit, levenberg_marquardt, residuals, side_by_side
from hfc_design.identify.identifiability import CONFIDENCE, Certainty, root_of

#: Number of profiles; they belong to the least certain parameters.
WORST = 2
#: Points of a profile on each side, in standard errors; largest change of a number from the fit.
PLACES, FURTHEST = (0.5, 1.0, 1.4, 1.8, 2.2), 1.5
#: Number of points of the parabola that a figure draws.
SMOOTH = 61
#: Most steps of Levenberg-Marquardt at each point; relative gain per step below which it ends.
STEPS, TOLERANCE = 4, 1e-5
#: Value of ``Profile.worse`` at the ends of the interval.
LIMIT = float(chi2.ppf(CONFIDENCE, 1))


class Profile(NamedTuple):
    """How much worse the fit becomes if one parameter is set to other values."""

    name: str  # of the parameter
    values: Floats  # (points,) of the parameter, rising; the fitted value is in the middle
    worse: Floats  # (points,) by how much twice the log likelihood falls
    supposed: Floats  # (2, SMOOTH) values, and ``worse`` as the interval supposes it: a parabola


def profiles(fit: Fit, known: Certainty) -> tuple[Profile, ...]:
    """Return the profiles of the ``WORST`` parameters that are known least."""
    worst = np.argsort(-digits(known.error), kind="stable")[:WORST]
    return tuple(_profile(fit, known, int(k)) for k in worst)


def _profile(fit: Fit, known: Certainty, k: int) -> Profile:
    """Return the profile of parameter ``k``; slopes predict where each fit of the others begins."""
    problem, error = fit.problem, np.sqrt(known.covariance[k, k])
    root = np.vstack([root_of(fit.jacobian, fit.problem.scale), np.eye(len(fit.numbers)) / VAGUE])
    others = np.arange(len(fit.numbers)) != k
    along = np.ones(len(fit.numbers))
    along[others] = -np.linalg.lstsq(root[:, others], root[:, k])[0]
    places = np.array(PLACES)
    far = np.minimum(places * error, places / PLACES[-1] * FURTHEST)
    steps = np.outer([*-far[::-1], *far], along)
    lanes = fit.numbers + np.clip(steps, -FURTHEST, FURTHEST)
    alone = problem._replace(moves=others * problem.moves)

    def again(numbers: Floats) -> float:
        ended, _ = levenberg_marquardt(alone, numbers, TOLERANCE, STEPS)
        return alone.squares(residuals(alone, ended))

    def values(numbers: Floats) -> Floats:
        """Return values of parameter ``k`` in its unit from its ``numbers`` (scaled or ln)."""
        return np.array([fit.free.values(np.where(others, fit.numbers, x))[k] for x in numbers])

    least = problem.squares(fit.residual)
    cost = np.insert(side_by_side(again, lanes), len(far), least)
    numbers = np.insert(lanes[:, k], len(far), fit.numbers[k])
    worse = fit.residual.size * (cost / least - 1.0) / known.inflated[k]
    smooth = np.linspace(numbers[0], numbers[-1], SMOOTH)
    supposed = np.array([values(smooth), ((smooth - fit.numbers[k]) / error) ** 2])
    return Profile(fit.free.names[k], values(numbers), np.maximum(worse, 0.0), supposed)
