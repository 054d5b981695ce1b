"""Profiles of the least certain parameters, and advice on what to record next.

Profile likelihood: one parameter is held off its value, and all others are fitted again at every
place (Raue et al., Bioinformatics 25, 2009). The intervals assume a parabola; a curve that stays
flat on one side gives an end of the interval on the other side only.

The advice is the recording with the most information that the log lacks. Commands of a few shapes
are simulated on the machine as identified so far; the value of a recording is its Fisher
information, added to that of the log (Ljung, System Identification, 1999, sec. 13.3).
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from hfc_design.core.numbers import Floats, digits, within
from hfc_design.identify.fit import VAGUE, Fit, levenberg_marquardt, residuals, side_by_side, slopes
from hfc_design.identify.identifiability import CONFIDENCE, Certainty, errors_of, root_of
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import replay

#: Duration of each command [s], and its largest number of samples.
LASTS, SAMPLES = 5.0, 10_000
#: Frequencies [Hz], none above this share of the samples; amplitudes as shares of the largest
#: recorded command.
FREQUENCIES, FASTEST = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0), 0.1
AMPLITUDES = (0.2, 0.5, 1.0)
#: Largest travel and speed as multiples of those of the log.
FURTHER = 1.5
#: Number of parameters whose gain is shown, and least gain of the best of them (a logarithm).
SHOWN, WORTH = 2, 0.1
#: Standard error below which a parameter is known well enough.
ENOUGH = 1e-3
#: Number of parameters with a profile, the least certain ones.
WORST = 2
#: Places on either side, in standard errors; no number leaves its value further than ``FURTHEST``.
PLACES, FURTHEST = (0.5, 1.0, 1.4, 1.8, 2.2), 1.5
#: Points of the parabola.
SMOOTH = 61
#: Replays of Levenberg-Marquardt at each place, after the prediction by the slopes.
STEPS, TOLERANCE = 4, 1e-5
#: Deterioration of the fit at the ends of the interval.
LIMIT = float(chi2.ppf(CONFIDENCE, 1))


class Advice(NamedTuple):
    """A recommended command for the next recording."""

    amplitude: float  # of a sine of the command [its unit]
    frequency: float  # [Hz]
    duration: float  # [s]
    travel: float  # from end to end [unit of the position]
    speed: float  # [the same per s]
    errors: dict[str, tuple[float, float]]  # name -> relative standard error before and after


def advice(fit: Fit, known: Certainty, log: Recording, substeps: int) -> Advice | None:
    """The sine that adds most to the information of the log; None: none adds much."""
    if log.command is None or (known.identifiable.all() and known.error.max() < ENOUGH):
        return None
    every, names = log.sample_time, fit.free.names
    steps = min(round(LASTS / every), SAMPLES)
    pairs = _shapes(float(np.abs(log.command).max()), every, steps)
    if not pairs:  # samples too slow for the slowest sine
        return None
    time, before = every * np.arange(steps), root_of(fit.jacobian, fit.problem.scale)

    def tried(pair: tuple[float, float]) -> tuple[float, float, Floats]:
        command = pair[0] * np.sin(2.0 * np.pi * pair[1] * time)
        place, slopes = _simulated(fit, log, command, substeps)
        error = errors_of(before, root_of(np.nan_to_num(slopes), fit.problem.scale))
        after = (error * np.sqrt(known.inflated))[:-2] * fit.free.shares(fit.numbers)
        return *_travel_and_speed(place, every), after

    travel, speed, after = map(np.array, zip(*side_by_side(tried, pairs), strict=True))
    far, fast = _travel_and_speed(log.place, every)
    allowed = (travel <= FURTHER * far) & (speed <= FURTHER * fast)
    least = np.argsort(-digits(known.error), kind="stable")[:SHOWN]
    wanted = least if known.identifiable.all() else np.flatnonzero(~known.identifiable)
    gains = np.log(known.error[wanted] / after[:, wanted])
    total = np.where(allowed & np.isfinite(gains).all(axis=1), gains.sum(axis=1), -np.inf)
    k = int(total.argmax())
    if not np.isfinite(total[k]) or gains[k].max() < WORTH:
        return None
    best = wanted[np.argsort(-digits(gains[k]), kind="stable")[:SHOWN]]
    errors = {names[i]: (float(known.error[i]), float(after[k, i])) for i in best}
    return Advice(*pairs[k], steps * every, float(travel[k]), float(speed[k]), errors)


def _travel_and_speed(place: Floats, every: float) -> tuple[float, float]:
    """Travel of an axis at (steps,) places ``every`` s, and its largest speed."""
    return np.ptp(place), np.abs(np.diff(place)).max() / every


def _shapes(largest: float, every: float, steps: int) -> list[tuple[float, float]]:
    """Amplitudes and frequencies of the sines."""
    allowed = [f for f in FREQUENCIES if within(1.0 / (steps * every), f, FASTEST / every)]
    return [(share * largest, f) for share in AMPLITUDES for f in allowed]


def _simulated(fit: Fit, log: Recording, command: Floats, substeps: int) -> tuple[Floats, Floats]:
    """(steps,) simulated positions of the axis, and slopes (steps, outputs, numbers) of its log.

    A command that is shorter than the log is simulated over the length of the log, so that one
    program serves both; the additional samples do not count.
    """
    steps = len(command)
    still = np.zeros(max(steps, len(log.load)))
    blank = log._replace(
        outputs=dict.fromkeys(log.outputs, still),
        command=np.append(command, still[steps:]),
        load=still,
        added=still,
        usable=np.append(np.ones(steps), still[steps:]),
        rate=0.0,
    )
    alone = fit.problem._replace(residual=replay(fit.free, blank, 0.0, substeps))
    shown = -residuals(alone, np.append(fit.numbers[:-2], [0.0, 0.0]))
    seen = blank._replace(outputs=dict(zip(log.outputs, shown.T, strict=True)))
    observed = alone._replace(
        residual=replay(fit.free, seen, fit.problem.bandwidth or 0.0, substeps)
    )
    return shown[:steps, 0], slopes(observed, fit.numbers)[1][:steps]


class Profile(NamedTuple):
    """Deterioration of the fit while one parameter is held off its value."""

    name: str
    values: Floats  # (places,) rising, the fitted one in the middle
    worse: Floats  # (places,) by which twice the logarithm of the likelihood falls
    supposed: Floats  # (2, points) values, and the parabola there that its interval supposes


def profiles(fit: Fit, known: Certainty) -> tuple[Profile, ...]:
    """Profiles of the parameters that are known least."""
    worst = np.argsort(-digits(known.error), kind="stable")[:WORST]
    return tuple(_profile(fit, known, int(k)) for k in worst)


def _profile(fit: Fit, known: Certainty, k: int) -> Profile:
    """Profile of one parameter; the others start from the prediction by their slopes."""
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
        """Values of the parameter in its unit, from scaled or logarithmic ``numbers``."""
        return np.array([fit.free.values(np.where(others, fit.numbers, x))[k] for x in numbers])

    least = problem.squares(fit.residual)
    cost = np.insert(side_by_side(again, lanes), len(far), least)
    numbers = np.insert(lanes[:, k], len(far), fit.numbers[k])
    worse = fit.residual.size * (cost / least - 1.0) / known.inflated[k]
    smooth = np.linspace(numbers[0], numbers[-1], SMOOTH)
    supposed = np.array([values(smooth), ((smooth - fit.numbers[k]) / error) ** 2])
    return Profile(fit.free.names[k], values(numbers), np.maximum(worse, 0.0), supposed)
