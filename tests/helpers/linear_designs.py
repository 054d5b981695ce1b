"""Linear designs of the C-axis, and the sledge as SciPy has it."""

import numpy as np
from scipy.signal import cont2discrete

from hfc_design.files.design import Design

EVERY = 0.01
MASS, FRICTION = 2.0, 3.0
STILL = {"error": 0.0, "error_rate": 0.0, "reference_rate": 0.0, "reference_acceleration": 0.0}


def design(limit=None, every=EVERY, **own):
    data = {
        "name": "mine",
        "plant": {"name": "c-axis", "parameters": {}},
        "controller": {"kind": "pid+ff", "sample_time_s": every, "kp": 0.0} | own,
        "limits": {"command": limit} if limit else {},
    }
    return Design.model_validate(data)


def one(frequency, in_phase, quadrature):
    return {"frequency_rad_s": frequency, "in_phase": in_phase, "quadrature": quadrature}


def plant():
    """(a, b) of place and speed of a mass under viscous friction, held for a sample."""
    rates = np.array([[0.0, 1.0], [0.0, -FRICTION / MASS]])
    a, b, *_ = cont2discrete((rates, np.array([[0.0], [1.0 / MASS]]), np.eye(2), 0), EVERY)
    return a, b[:, 0]


def filters(in_phase, quadrature, angle):
    """Numerator and denominator in z^-1: T (p (z - cos) - q sin) / (z^2 - 2 cos z + 1)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    above = EVERY * np.array([0.0, in_phase, -in_phase * cosine - quadrature * sine])
    return above, np.array([1.0, -2.0 * cosine, 1.0])
