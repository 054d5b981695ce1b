"""Motions like those of a log: as far, as fast, as slow as a loop that is to be better may go."""

from typing import Any

import numpy as np

from hfc_design.core.numbers import Json
from hfc_design.files.motions import LEAST_STEPS
from hfc_design.identify.replay import Recording

#: A step is so many times the error of the loop that recorded the log (rms), if the scale tells it.
STEP = 3.0


def fastest(told: Recording) -> tuple[float, float]:
    """Speed and acceleration that the log reaches, but for its noise."""
    place = told.place if told.reference is None else told.reference
    width = max(min(round(0.01 / told.sample_time), len(place) // 8), 1)
    smooth = np.convolve(place, np.ones(width) / width, "valid")
    rate = (smooth[width:] - smooth[:-width]) / (width * told.sample_time)
    change = (rate[width:] - rate[:-width]) / (width * told.sample_time)
    speed = max(float(np.quantile(np.abs(rate), 0.99)), float(np.ptp(place)) / told.duration)
    return speed, max(float(np.quantile(np.abs(change), 0.99)), speed)


def motions_like(
    told: Recording, speed: float, acceleration: float, duration: float, error: float
) -> list[Json]:
    """A move as far as that of the log, a slow one, one to and fro, and a step."""
    distance, slow = float(np.ptp(told.place)), 0.05 * speed
    lasts = distance / speed + speed / acceleration
    # Two periods, so that it reverses at the end too; no faster than the log.
    often = min(4.0 * np.pi / duration, 5.0 * acceleration / speed)
    move = _rounded(
        kind="trapezoidal", distance=distance, velocity=speed, acceleration=acceleration
    )
    sine = _rounded(kind="sine", amplitude=0.2 * speed / often, frequency_rad_s=often)
    step = _rounded(kind="step", height=max(STEP * error, LEAST_STEPS * (told.step or 0.0)))
    return [
        {"name": "move", "reference": move, "settled_after_s": round(1.2 * lasts + 0.2, 2)},
        {"name": "slow", "reference": _rounded(kind="ramp", velocity=slow)},
        {"name": "reversal", "reference": sine},
        {"name": "step", "reference": step, "settled_after_s": round(0.5 * duration, 2)},
    ]


def _rounded(**reference: Any) -> Json:
    return {key: float(f"{x:.3g}") if isinstance(x, float) else x for key, x in reference.items()}
