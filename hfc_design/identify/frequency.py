"""Frequency response of a machine from its log, with coherence, and the modes that it shows.

Spectra are estimated by Welch's method (IEEE Trans. AU-15, 1967). In a closed loop, noise of the
position returns in the command, so that their ratio (H1) would be biased. Both are therefore
compared with what moves the loop from outside, a signal added to the command, or the reference:
the response of the drive is the ratio of two H1 estimates (joint input-output method).
"""

from typing import Any

import numpy as np
from scipy.ndimage import median_filter
from scipy.optimize import least_squares
from scipy.signal import csd, find_peaks

from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError
from hfc_design.identify.recording import Recording
from hfc_design.stability.frequency import KNOWN, FrequencyResponse, Mode, response_units
from plants import Drive

#: Largest length of a segment [samples], least number of segments, least length [samples]; number
#: of independent segments that one with half overlap counts as (Welch).
SEGMENT, PARTS, LEAST, OVERLAP = 16384, 5, 32, 0.82
#: Number of neighbouring frequencies whose median coherence counts; coherence that counts alone.
CALM, NO_CHANCE = 9, 0.9
#: Least power of an added signal at a frequency, as a share of its largest: else nothing is known.
EXCITED = 1e-4
#: Modes: least factor of a peak over its surroundings; width of the fit as a factor on the
#: frequency; dampings from which it starts; least number of frequencies; factor by which the mode
#: has to reduce the squares; largest standard error of its frequency, as a share of it.
FACTOR, FITTED, DAMPINGS, FEWEST = 1.25, 1.35, (0.003, 0.01, 0.03, 0.1), 12
BETTER, SHARP = 4.0, 0.03


def density(first: Floats, second: Floats, length: int, every: float) -> Any:
    """Return the cross spectral density of two signals from the second frequency on, complex."""
    bent: Any = "linear"  # which the types of SciPy do not know
    return csd(first, second, 1.0 / every, nperseg=length, detrend=bent)[1][2:]


def frequencies(length: int, every: float) -> Floats:
    """Return the frequencies of ``density`` [Hz]."""
    return np.arange(2.0, length // 2 + 1) / (length * every)


def longest(usable: Floats) -> slice:
    """Return the longest part of a log in which all samples count."""
    ends = np.flatnonzero(np.diff(np.r_[0, usable > 0, 0]))
    k = int(np.argmax(ends[1::2] - ends[::2]))
    return slice(int(ends[2 * k]), int(ends[2 * k + 1]))


def measured_response(log: Recording, drive: Drive, source: str) -> FrequencyResponse:
    """Return the frequency response of a recorded drive; the loop too, if a signal was added.

    Raises:
        UserError: the log has no command or is too short, or nothing in it is coherent.
    """
    part, every = longest(log.usable), log.sample_time
    if log.command is None:
        raise UserError(f"{source}: needs the command beside the position")
    length = min(SEGMENT, (part.stop - part.start) // PARTS)
    if length < LEAST:
        raise UserError(
            f"{source}: must have at least {LEAST * PARTS} samples without a gap "
            f"(got {part.stop - part.start})"
        )
    outside, notes = _outside(log)
    # Second differences, as a slow motion would leak into all frequencies.
    x, u, y, w = (np.diff(one[part], 2) for one in (outside, log.command, log.place, log.load))
    hertz = frequencies(length, every)

    def coherence(first: Floats, second: Floats) -> Floats:
        both = density(first, second, length, every)
        powers = [density(one, one, length, every).real for one in (first, second)]
        with np.errstate(all="ignore"):
            return np.asarray(np.nan_to_num(np.abs(both) ** 2 / np.prod(powers, axis=0)))

    to_command, to_place = (density(x, one, length, every) for one in (u, y))
    trust = np.minimum(coherence(x, u), coherence(x, y))
    # A few frequencies of noise are coherent by chance; of a log of single sines only few are.
    trust = np.where(trust > NO_CHANCE, trust, median_filter(trust, CALM, mode="nearest"))
    if np.ptp(log.added):
        power = density(log.added[part], log.added[part], length, every).real
        trust = np.where(power >= EXCITED * power.max(), trust, 0.0)
    if not (trust >= KNOWN).any():
        raise UserError(
            f"{source}: the coherence is below {KNOWN:g} at all frequencies (largest "
            f"{trust.max():.2g}): the log does not excite the axis; see hfc experiment"
        )
    independent = OVERLAP * (2.0 * (part.stop - part.start) / length - 1.0)
    with np.errstate(all="ignore"):
        error = np.sqrt((1.0 - trust) / (2.0 * trust * independent))
        response = to_place / to_command
        open_loop = (density(x, x, length, every) / to_command - 1.0)[None]
        soft = (density(w, y, length, every) / density(w, w, length, every))[None]
    loops = open_loop if np.ptp(log.added) else None, soft if np.ptp(w) else None
    its_modes = tuple(modes(hertz, response, error, trust >= KNOWN))
    about = (response[None], trust, response_units(drive.units), *loops, error, its_modes)
    return FrequencyResponse(source, hertz, every, *about, (*log.notes, *notes))


def _outside(log: Recording) -> tuple[Floats, list[str]]:
    """Return the signal that moves the loop from outside, and a note if there is none."""
    assert log.command is not None
    if np.ptp(log.added):
        return log.added, []
    if log.reference is not None and np.ptp(np.diff(log.reference, 2)):
        return log.reference, []
    return log.command, [
        "neither an added signal nor a reference is recorded: if the loop was closed, the response "
        "is biased by noise"
    ]


def modes(hertz: Floats, response: Any, error: Floats, known: Any) -> list[Mode]:
    """Return the modes at peaks of the acceleration per command (frequencies,)."""
    size = np.log(np.where(known, np.abs(response) * hertz**2, np.nan))
    size = median_filter(np.nan_to_num(size, nan=np.nanmin(size)), 3, mode="nearest")
    listed = list[Mode]()
    for k in find_peaks(size, width=2, prominence=np.log(FACTOR))[0]:
        near = known & (hertz > hertz[k] / FITTED) & (hertz < hertz[k] * FITTED)
        if known[k] and near.sum() >= FEWEST:
            mode = _mode(hertz[near], response[near], error[near], float(hertz[k]))
            if mode and all(abs(mode.hz / x.hz - 1.0) > SHARP for x in listed):
                listed.append(mode)
    return listed


def _mode(hertz: Floats, response: Any, error: Floats, peak: float) -> Mode | None:
    """Return the mode near ``peak`` that explains a response beside a smooth one; None: none does.

    The acceleration per command is a parabola of the frequency with complex coefficients, plus a
    complex share of the mode: delays and other modes only change these coefficients.
    """
    s = 1j * hertz / peak
    wanted, weight = response * hertz**2, 1.0 / (np.abs(response) * hertz**2 * error)
    smooth = [np.ones_like(s), s - 1j, (s - 1j) ** 2]

    def left(*columns: Any) -> Floats:
        rows = np.stack([x * weight for x in columns], axis=1)
        rest = rows @ np.linalg.lstsq(rows, wanted * weight)[0] - wanted * weight
        return np.append(rest.real, rest.imag)

    def of(place: Floats) -> Floats:
        w, damping = np.exp(place)
        swing = 1.0 / (s**2 + 2.0 * damping * w * s + w**2)
        return left(*smooth, swing, s * swing)

    starts = (np.array([0.0, np.log(damping)]) for damping in DAMPINGS)
    limits = ([-0.2, np.log(1e-4)], [0.2, np.log(0.5)])
    best = min((least_squares(of, x, bounds=limits) for x in starts), key=lambda x: x.cost)
    freedom = max(2 * len(s) - 12, 1)
    without = 0.5 * np.sum(left(*smooth, *((s - 1j) ** k for k in (3, 4))) ** 2)
    noise = max(2.0 * best.cost / freedom, 1.0)
    slopes = np.asarray(best.jac)
    spread = np.linalg.pinv(slopes.T @ slopes) * noise
    error_hz, error_damping = np.sqrt(np.diag(spread))
    if error_hz > SHARP or without < best.cost * BETTER:
        return None
    hz, damping = np.exp(best.x) * [peak, 1.0]
    return Mode(*map(float, (hz, damping, hz * error_hz, damping * error_damping)))
