"""What a log tells least: how the fit grows worse beside it, and what to record next.

Profile likelihood: one parameter is held off its value, and all others are fitted again at every
place (Raue et al., Bioinformatics 25, 2009). A parabola is what the intervals suppose; a curve that
stays flat on one side has an end on the other one only.

What to record next tells most of what the log does not tell yet. Commands of a few shapes are
simulated on the machine as it is known by now; what one would tell is its Fisher information, added
to that of the log (Ljung, System Identification, 1999, sec. 13.3).
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from hfc_design.core.numbers import Floats, digits, within
from hfc_design.identify.fit import VAGUE, Fit, Found, offs, refined, side_by_side, slopes
from hfc_design.identify.identifiability import CONFIDENCE, Certainty, errors_of, root_of
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import replay

#: How long each is [s], in at most so many samples.
LASTS, SAMPLES = 5.0, 10_000
#: Frequencies [Hz], none above this share of the samples; amplitudes as shares of the largest
#: command that was recorded.
FREQUENCIES, FASTEST = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0), 0.1
AMPLITUDES = (0.2, 0.5, 1.0)
#: It may go so many times as far and as fast as the log does.
FURTHER = 1.5
#: Of so many parameters it is said what they gain, if the best gains this at least (a logarithm).
SHOWN, WORTH = 2, 0.1
#: Whatever is known better than so (a standard error) is known well enough.
ENOUGH = 1e-3
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


class Advice(NamedTuple):
    """A command that is worth recording."""

    amplitude: float  # of a sine of the command [its unit]
    frequency: float  # [Hz]
    duration: float  # [s]
    travel: float  # from end to end [unit of the position]
    speed: float  # [the same per s]
    errors: dict[str, tuple[float, float]]  # name -> relative standard error before and after


def advice(found: Found, known: Certainty, told: Recording, substeps: int) -> Advice | None:
    """The sine that tells most of what the log does not tell; None: none tells much more."""
    if told.command is None:
        return None
    fit, free, every = found.fit, found.fit.free, told.sample_time
    steps = min(round(LASTS / every), SAMPLES)
    pairs = _shapes(float(np.abs(told.command).max()), every, steps)
    if not pairs:  # samples too slow for the slowest sine
        return None
    time = every * np.arange(steps)
    commands = np.array([a * np.sin(2.0 * np.pi * f * time) for a, f in pairs])
    each = side_by_side(lambda own: _simulated(found, told, own, substeps), commands)
    places, told_by = (np.stack(parts) for parts in zip(*each, strict=True))
    going = np.ptp(places, axis=1), np.abs(np.diff(places, axis=1)).max(axis=1) / every
    far = np.ptp(told.place), np.abs(np.diff(told.place)).max() / every
    allowed = (going[0] <= FURTHER * far[0]) & (going[1] <= FURTHER * far[1])
    shares = free.shares(fit.numbers)
    before, after = root_of(fit.jacobian, fit.scale), []
    for own in told_by:
        error = errors_of(before, root_of(np.nan_to_num(own), fit.scale))
        after.append((error * np.sqrt(known.inflated))[:-2] * shares)
    wanted = np.flatnonzero(~np.array(known.told))
    if not wanted.size:
        if known.error.max() < ENOUGH:
            return None
        wanted = np.argsort(-digits(known.error), kind="stable")[:SHOWN]
    gains = np.log(known.error[wanted] / np.array(after)[:, wanted])
    total = np.where(allowed & np.isfinite(gains).all(axis=1), gains.sum(axis=1), -np.inf)
    k = int(total.argmax())
    if not np.isfinite(total[k]) or gains[k].max() < WORTH:
        return None
    best = wanted[np.argsort(-digits(gains[k]), kind="stable")[:SHOWN]]
    errors = {free.names[i]: (float(known.error[i]), float(after[k][i])) for i in best}
    return Advice(*pairs[k], steps * every, float(going[0][k]), float(going[1][k]), errors)


def _shapes(largest: float, every: float, steps: int) -> list[tuple[float, float]]:
    allowed = [f for f in FREQUENCIES if within(1.0 / (steps * every), f, FASTEST / every)]
    return [(share * largest, f) for share in AMPLITUDES for f in allowed]


def _simulated(
    found: Found, told: Recording, command: Floats, substeps: int
) -> tuple[Floats, Floats]:
    """(steps,) where the axis would be, and slopes (steps, outputs, numbers) of its log.

    A log at least as long is one, of which the end does not count: one program does for both.
    """
    fit, steps = found.fit, len(command)
    still = np.zeros(max(steps, len(told.load)))
    counts, command = np.append(np.ones(steps), still[steps:]), np.append(command, still[steps:])
    blank = told._replace(outputs=dict.fromkeys(told.outputs, still), command=command, rate=0.0)
    blank = blank._replace(load=still, added=still, usable=counts)
    alone = found.problem._replace(residual=replay(fit.free, blank, 0.0, substeps))
    shown = -offs(alone, np.append(fit.numbers[:-2], [0.0, 0.0]))
    seen = blank._replace(outputs=dict(zip(told.outputs, shown.T, strict=True)))
    own = alone._replace(residual=replay(fit.free, seen, found.bandwidth or 0.0, substeps))
    return shown[:steps, 0], slopes(own, fit.numbers)[1][:steps]


class Profile(NamedTuple):
    """One parameter."""

    name: str
    values: Floats  # (places,) rising, the fitted one in the middle
    worse: Floats  # (places,) by which twice the logarithm of the likelihood falls
    supposed: Floats  # (2, points) values, and the parabola there that its interval supposes


def profiles(found: Found, known: Certainty) -> tuple[Profile, ...]:
    """Of the parameters that are known least."""
    worst = np.argsort(-digits(known.error), kind="stable")[:WORST]
    return tuple(_profile(found, known, int(k)) for k in worst)


def _profile(found: Found, known: Certainty, k: int) -> Profile:
    """Of one, from where the others would be by their slopes."""
    fit, problem, error = found.fit, found.problem, np.sqrt(known.covariance[k, k])
    root = np.vstack([root_of(fit.jacobian, fit.scale), np.eye(len(fit.numbers)) / VAGUE])
    others = np.arange(len(fit.numbers)) != k
    along = np.ones(len(fit.numbers))
    along[others] = -np.linalg.lstsq(root[:, others], root[:, k])[0]
    places = np.array(PLACES)
    far = np.minimum(places * error, places / PLACES[-1] * FURTHEST)
    steps = np.outer([*-far[::-1], *far], along)
    lanes = fit.numbers + np.clip(steps, -FURTHEST, FURTHEST)
    alone = problem._replace(held=others * problem.held)

    def again(numbers: Floats) -> float:
        ended, _ = refined(alone, numbers, TOLERANCE, STEPS)
        return alone.squares(offs(alone, ended))

    least = problem.squares(fit.residual)
    cost = np.insert(side_by_side(again, lanes), len(far), least)
    numbers = np.insert(lanes[:, k], len(far), fit.numbers[k])
    worse = fit.residual.size * (cost / least - 1.0) / known.inflated[k]
    smooth = np.linspace(numbers[0], numbers[-1], SMOOTH)
    supposed = np.array([_values(fit, k, smooth), ((smooth - fit.numbers[k]) / error) ** 2])
    values = _values(fit, k, numbers)
    return Profile(fit.free.names[k], values, np.maximum(worse, 0.0), supposed)


def _values(fit: Fit, k: int, numbers: Floats) -> Floats:
    """(places,) the parameter ``k`` in its unit where its number is one of ``numbers``."""
    place = np.arange(len(fit.numbers)) == k
    return np.array([fit.free.values(np.where(place, x, fit.numbers))[k] for x in numbers])
