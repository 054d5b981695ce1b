"""The published method: least squares of the inverse dynamics, from filtered positions.

M. Gautier, A. Janot and P.-O. Vandanjon, "A new closed-loop output error method for parameter
identification of robot dynamics", IEEE Transactions on Control Systems Technology 21 (2013).
"""

import numpy as np
from scipy.signal import butter, decimate, filtfilt

from experiments.emps.logs import GAIN, SAMPLE, Floats, Log

#: Of the filter of the positions [Hz], and the samples that it spoils at both ends.
CUTOFF = 50.0
ENDS = 50
#: Samples that become one, in two steps as SciPy advises.
FEWER = (5, 5)


def decimated(values: Floats) -> Floats:
    """One of every 25 samples but those of the ends, low-pass filtered without a shift."""
    values = values[ENDS:-ENDS]
    for factor in FEWER:
        values = decimate(values, factor)
    return values


def inverse_dynamics(one: Log) -> dict[str, float]:
    """Parameters with which measured motion asks for the recorded force, the least off in squares.

    Force = mass acceleration + viscous speed + Coulomb sign(speed) + offset [N, m]; the filter runs
    to and fro, and so shifts nothing.
    """
    top, bottom = butter(4, 2.0 * SAMPLE * CUTOFF)
    speed = np.gradient(filtfilt(top, bottom, 1e-3 * one.position), SAMPLE)
    terms = (np.gradient(speed, SAMPLE), speed, np.sign(speed), np.ones_like(speed))
    force = decimated(GAIN * one.command)
    found = np.linalg.lstsq(np.stack([*map(decimated, terms)], axis=1), force, rcond=None)[0]
    names = ("mass", "viscous_friction", "coulomb_friction", "offset")
    return dict(zip(names, found.tolist(), strict=True))
