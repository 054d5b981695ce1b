"""Comparison of the log and the model by frequency: missing modes, unexcited frequencies.

The response of the log from command to position is estimated by Welch's method. That of the model
follows from the residual, because the correction by the observer is known. Both use second
differences, since a slow motion would leak into all frequencies. In a closed loop, noise of the
position returns in the command: at most by its share of the position, which counts as error.
"""

from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from hfc_design.core.numbers import Floats
from hfc_design.files.stress import Mode
from hfc_design.identify.fit import NOTHING, Fit
from hfc_design.identify.frequency import LEAST, OVERLAP, density, frequencies, longest
from hfc_design.identify.replay import DAMPED, Replay

#: Largest length of a segment [samples], least number of segments.
SEGMENT, PARTS = 1024, 8
#: Relative error of the response up to which a frequency counts as excited.
KNOWN = 0.25
#: Modes: number of frequencies, dampings; highest frequency, in sampling rates and in ``top``.
MODES, DAMPINGS, HIGHEST, BEYOND = 80, (0.01, 0.03, 0.1, 0.2), 0.4, 1.25
#: Least fall of the squares by a mode, in mean squares of the rest; least change of the response.
CLEAR, CHANGES = 30.0, 0.15
#: Number of autocorrelations of the residual, and their limit in standard errors.
LAGS, FAR = 40, 1.96

UNEXCITED = (
    "DOUBTFUL: the log has no excitation: the response to the command is below the noise "
    "at all frequencies; record reversals and faster motions"
)
#: Share of the highest frequency of a log up to which excitation is expected; share of the
#: autocorrelations of white noise that may exceed their limit.
ALL, WHITE = 0.8, 0.15


class Response(NamedTuple):
    """Responses (frequencies,) of a log and of the model, and conclusions from them."""

    frequency: Floats  # [Hz]
    log: Any  # complex, from command to position
    model: Any  # complex
    coherence: Floats
    top: float | None  # highest excited frequency [Hz]; None: none was excited
    mode: Mode | None  # that the model lacks; None: none was found
    coloured: int  # number of the ``LAGS`` autocorrelations of the residual beyond their limit

    @property
    def unknown_above(self) -> float:
        """Frequency above which modes are unknown [Hz]."""
        return float(f"{self.top or self.frequency[0]:.2g}")

    def lines(self) -> list[str]:
        """Return what the frequencies of the log say about the model, a line each."""
        if self.top is None:
            return [UNEXCITED]
        lines = []
        if self.top <= ALL * self.frequency[-1]:
            lines.append(
                f"nothing above {self.unknown_above:g} Hz was excited, so a mode there "
                "cannot be excluded: design for one, or record faster motions"
            )
        if self.mode:
            lines.append(f"there is a mode near {self.mode.hz:g} Hz that the model does not have")
        incomplete = "is not white (the model is incomplete)"
        white = "is white" if self.coloured <= WHITE * LAGS else incomplete
        count = f"{self.coloured} of {LAGS} autocorrelations differ from white noise"
        return [*lines, f"the residual {white}: {count}"]


def response(fit: Fit) -> Response | None:
    """Return the response of log and model; None: a closed loop was fitted, or the log is short."""
    replay = fit.problem.residual
    if not isinstance(replay, Replay):
        return None
    every, part = float(replay.sample_time), longest(np.asarray(replay.rows.usable))
    off, place, command = fit.residual[part, 0], replay.rows.place[part], replay.rows.command
    length = min(SEGMENT, len(off) // PARTS)
    if length < LEAST:
        return None
    bends = np.diff(off, 2), np.diff(place, 2), np.asarray(command)[part][1:-1]

    frequency = frequencies(length, every)
    missing, answer, power = (density(bends[2], x, length, every) for x in bends)
    turn = np.exp(2j * np.pi * frequency * every) - 1.0
    w = 2.0 * np.pi * (fit.problem.bandwidth or 0.0) * every
    slow = (2.0 * DAMPED * w + w**2) * turn + w**2
    model = answer - missing * (turn**2 + slow) / turn**2
    noise = np.median(np.abs(bends[0])) / 0.6745 / np.sqrt(6.0)
    seen = density(bends[1], bends[1], length, every).real
    coherence = np.abs(answer) ** 2 / (power.real * seen)
    count = OVERLAP * (2.0 * len(off) / length - 1.0)
    back = np.sqrt(2.0 * every * noise**2 * np.abs(turn) ** 4 / seen)
    error = back + np.sqrt((1.0 - coherence) / (2.0 * coherence * count))
    excited = np.flatnonzero(median_filter(error, 5, mode="nearest") < KNOWN)
    excited = excited if excited.size else np.flatnonzero(error < KNOWN)  # for a log of one sine
    top = float(frequency[excited[-1]]) if excited.size else None
    counts = (error < KNOWN) & (frequency >= 0.5 * (fit.problem.bandwidth or 0.0))
    counts &= frequency <= (top or 0.0)
    mode = _mode(frequency, answer / model, error, counts, 0.5 / every)
    if mode and mode.hz > min(BEYOND * (top or 0.0), HIGHEST / every):
        mode = None  # so far below a mode, other errors of the model look like it
    size = turn**2 * power.real
    curves = frequency, answer / size, model / size, coherence
    left = np.std(off) > NOTHING * np.std(place)  # otherwise the residual is only rounding
    return Response(*curves, top, mode, _coloured(off) if left else 0)


def _coloured(off: Floats) -> int:
    """Return the number of autocorrelations that are too large for white noise."""
    off = off - off.mean()
    products = np.array([off[k:] @ off[:-k] for k in range(1, LAGS + 1)])
    shares = products / max(off @ off, 1e-300)
    return int((np.abs(shares) > FAR / np.sqrt(len(off))).sum())


def _mode(
    frequency: Floats, ratio: Any, error: Floats, counts: Floats, highest: float
) -> Mode | None:
    """Return the mode that explains ``ratio`` (response of the log / of the model); None: no mode.

    If the measured mass itself oscillates (share -1), the mode is visible below its frequency too.
    """
    s, seen = 2j * np.pi * frequency, frequency[counts]
    if counts.sum() < 8:
        return None

    def left(*columns: Any) -> tuple[float, Floats]:
        weighted = [(x * np.ones(len(s)))[counts] / error[counts] for x in (*columns, ratio)]
        *rows, wanted = (np.append(x.real, x.imag) for x in weighted)
        solution = np.linalg.lstsq(np.stack(rows, axis=1), wanted)[0]
        return float(np.sum((np.stack(rows, axis=1) @ solution - wanted) ** 2)), solution

    least, best = np.inf, None
    for hz, damping in product(np.geomspace(seen[0], highest, MODES), DAMPINGS):
        w = 2.0 * np.pi * hz
        swing = s**2 / (s**2 + 2.0 * damping * w * s + w**2)
        tried = [(left(1.0 - swing, s * (1.0 - swing))[0], -1.0)]
        if hz <= seen[-1]:
            squares, solution = left(1.0 + 0.0 * s, s, swing)
            tried.append((squares, solution[2] / solution[0]))
        for squares, share in tried:
            if squares < least and abs(share) * np.abs(swing[counts]).max() > CHANGES:
                least, best = squares, (hz, damping, share)
    clear = left(1.0 + 0.0 * s, s)[0] - least > CLEAR * least / counts.sum()
    if best is None or not clear:
        return None
    hz, damping, share = (float(f"{x:.2g}") for x in best)
    return Mode(hz=hz, damping=damping, share=max(share, -1.0))
