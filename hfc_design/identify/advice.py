"""Profiles of the least certain parameters, and advice on what to record next.

A profile shows how much worse the fit becomes if one parameter is set to other values and the rest
is fitted again at each (profile likelihood; Raue et al., Bioinformatics 25, 2009). The intervals
assume a parabola. A curve that is flat on one side bounds the parameter on the other side only.

The advice is a sine of the command. Sines of several amplitudes and frequencies are simulated on
the machine as identified so far. The best one adds most Fisher information on the least certain
parameters to that of the log (Ljung, System Identification, 1999, sec. 13.3).
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from hfc_design.core.numbers import Floats, digits, within
from hfc_design.identify.fit import VAGUE, Fit, levenberg_marquardt, residuals, side_by_side, slopes
from hfc_design.identify.identifiability import CONFIDENCE, Certainty, errors_of, root_of
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import replay

#: Duration of each simulated command [s], and its largest number of samples.
LASTS, SAMPLES = 5.0, 10_000
#: Frequencies of the sines [Hz], up to ``FASTEST`` times the sampling rate; their amplitudes as
#: shares of the largest recorded command.
FREQUENCIES, FASTEST = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0), 0.1
AMPLITUDES = (0.2, 0.5, 1.0)
#: Largest travel and speed under a sine, as multiples of those in the log.
FURTHER = 1.5
#: Number of parameters that the advice names; least ln(error before / error after) of the best one.
SHOWN, WORTH = 2, 0.1
#: Relative standard error below which a parameter is known well enough.
ENOUGH = 1e-3
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


class Advice(NamedTuple):
    """A recommended command for the next recording."""

    amplitude: float  # of a sine of the command [unit of the command]
    frequency: float  # [Hz]
    duration: float  # [s]
    travel: float  # from end to end [unit of the position]
    speed: float  # largest [unit of the position per s]
    errors: dict[str, tuple[float, float]]  # parameter -> relative standard error before and after


def advice(fit: Fit, known: Certainty, log: Recording, substeps: int) -> Advice | None:
    """Return the sine that adds most information to the log; None: none is needed or helps much."""
    if log.command is None or (known.identifiable.all() and known.error.max() < ENOUGH):
        return None
    every, names = log.sample_time, fit.free.names
    steps = min(round(LASTS / every), SAMPLES)
    pairs = _shapes(float(np.abs(log.command).max()), every, steps)
    if not pairs:  # the sampling rate is too low even for the slowest sine
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
    """Return travel and largest speed of an axis from its positions (steps,), ``every`` s apart."""
    return np.ptp(place), np.abs(np.diff(place)).max() / every


def _shapes(largest: float, every: float, steps: int) -> list[tuple[float, float]]:
    """Return (amplitude, frequency [Hz]) of each sine; ``largest`` is the highest amplitude."""
    allowed = [f for f in FREQUENCIES if within(1.0 / (steps * every), f, FASTEST / every)]
    return [(share * largest, f) for share in AMPLITUDES for f in allowed]


def _simulated(fit: Fit, log: Recording, command: Floats, substeps: int) -> tuple[Floats, Floats]:
    """Return positions (steps,) simulated under a command, and slopes (steps, outputs, names + 2).

    The slopes are those of the residual of a log of this motion. A command shorter than the log is
    extended to its length, so that one compiled program serves both; these samples do not count.
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
