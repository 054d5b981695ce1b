"""Profile likelihood: how the fit grows worse while one parameter is held off its value.

All others are fitted again at every place (Raue et al., Bioinformatics 25, 2009). A parabola is
what the intervals suppose; a curve that stays flat on one side has an end on the other one only.
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from hfc_design.core.numbers import Floats, digits
from hfc_design.identify.certainty import CONFIDENCE, Certainty, root_of
from hfc_design.identify.fit import VAGUE, Fit, offs, refined, side_by_side
from hfc_design.identify.search import Found

#: Of so many parameters, those that the log tells least.
WORST = 2
#: Places on either side, in standard errors; no number leaves its value further than ``FURTHEST``.
PLACES, FURTHEST = (0.5, 1.0, 1.4, 1.8, 2.2), 1.5
#: Points of the parabola.
SMOOTH = 61
#: Replays of Levenberg-Marquardt at each place, after what the slopes say.
STEPS, TOLERANCE = 4, 1e-5
#: By which the fit has grown worse at the ends of the interval.
LIMIT = float(chi2.ppf(CONFIDENCE, 1))


class Profile(NamedTuple):
    """One parameter."""

    name: str
    values: Floats  # (places,) rising, the fitted one in the middle
    worse: Floats  # (places,) by which twice the logarithm of the likelihood falls
    supposed: Floats  # (2, points) values, and the parabola there that its interval supposes


def profiles(found: Found, known: Certainty) -> tuple[Profile, ...]:
    """Of the parameters that are known least."""
    fit = found.fit
    worst = np.argsort(-digits(known.error), kind="stable")[:WORST]
    error = np.sqrt(np.diag(known.covariance))
    root = np.vstack([root_of(fit.jacobian, fit.scale), np.eye(len(fit.numbers)) / VAGUE])
    lanes, held = [], []
    for k in worst:
        far = np.minimum(np.array(PLACES) * error[k], np.array(PLACES) / PLACES[-1] * FURTHEST)
        for place in (*-far[::-1], *far):
            others = np.arange(len(fit.numbers)) != k
            step = np.zeros(len(fit.numbers))
            step[k] = place
            step[others] = -place * np.linalg.lstsq(root[:, others], root[:, k])[0]
            lanes.append(fit.numbers + np.clip(step, -FURTHEST, FURTHEST))
            held.append(others * found.problem.held)

    def again(numbers: Floats, held: Floats) -> float:
        own = found.problem._replace(held=held)
        ended, _ = refined(own, numbers, TOLERANCE, STEPS)
        return own.squares(offs(own, ended))

    cost = np.array(side_by_side(lambda own: again(*own), zip(lanes, held, strict=True)))
    least = found.problem.squares(fit.residual)
    rows = np.array(lanes).reshape(len(worst), -1, len(fit.numbers))
    told = []
    for row, k, own in zip(rows, worst, cost.reshape(len(worst), -1), strict=True):
        half = len(own) // 2
        numbers = np.insert(row[:, k], half, fit.numbers[k])
        worse = fit.residual.size * (np.insert(own, half, least) / least - 1.0) / known.inflated[k]
        smooth = np.linspace(numbers[0], numbers[-1], SMOOTH)
        parabola = ((smooth - fit.numbers[k]) / error[k]) ** 2
        supposed = np.array([_values(fit, k, smooth), parabola])
        values = _values(fit, k, numbers)
        told.append(Profile(fit.free.names[k], values, np.maximum(worse, 0.0), supposed))
    return tuple(told)


def _values(fit: Fit, k: int, numbers: Floats) -> Floats:
    """(places,) the parameter ``k`` in its unit where its number is one of ``numbers``."""
    place = np.arange(len(fit.numbers)) == k
    return np.array([fit.free.values(np.where(place, x, fit.numbers))[k] for x in numbers])
