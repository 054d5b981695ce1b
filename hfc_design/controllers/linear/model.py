"""What a nominal drive tells of linear gains: what is fed forward, a first PID."""

from collections.abc import Sequence

import numpy as np

from hfc_design.controllers.linear.law import LinearGains
from hfc_design.controllers.linear.record import MULTIPLES
from hfc_design.core.numbers import Floats, Scalar
from hfc_design.stability.nominal import Nominal

#: Bandwidths that are tried, in shares of one over the sample time.
BANDWIDTHS = (1e-3, 0.5)
#: How much slower the integral of a first controller is than its loop.
INTEGRAL = 0.1
#: Factors on the loop gain at which the first controller is stable too.
ROOM = (0.5, 1.0, 2.0)


def ahead(model: Nominal, signals: dict[str, Floats]) -> dict[str, Floats]:
    """What the nominal drive asks for, less what gains on ``signals`` give of it by themselves."""
    found = {}
    for name in MULTIPLES:
        steady = getattr(model, name)
        own = sum(gain * (model.outputs[key] @ steady.state) for key, gain in signals.items())
        found[name] = steady.command - own
    return found


def bandwidth(model: Nominal, sample_time: float) -> float:
    """The largest bandwidth [1/s] of a PID whose loop has room for other gains."""
    best = 0.0
    for speed in np.geomspace(*BANDWIDTHS, 55) / sample_time:
        gains = LinearGains(*map(float, pid(model, speed)))
        closed = (_closed(model, gains, sample_time, room) for room in ROOM)
        stable = all(abs(np.linalg.eigvals(loop)).max() < 1.0 for loop in closed)
        if stable or not best:
            best = float(speed)
    return best


def pid(model: Nominal, speed: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """kp, ki, kd of a bandwidth [1/s].

    They make the nominal drive, taken for ``acceleration s^2 + velocity s``, critically damped.
    """
    mass, drag = abs(model.acceleration.command), abs(model.velocity.command)
    kp = mass * speed**2 + drag * speed
    return kp, INTEGRAL * speed * kp, 2.0 * mass * speed


def answer(
    model: Nominal, gains: dict[str, Floats], signals: Sequence[str], z: complex, sample_time: float
) -> Floats:
    """(n,) error that a command of 1 at ``z`` brings about, complex, in the loop of a PID.

    ``gains`` are kp, ki, kd, kept and those on ``signals``, each (n,).
    """
    state = np.linalg.solve(z * np.eye(len(model.b)) - model.a, model.b)
    told = {name: row @ state for name, row in model.outputs.items()}
    filtered = gains["kd"] * (1.0 - gains["kept"]) * z / (z - gains["kept"])
    command = (gains["kp"] + gains["ki"] * sample_time / (z - 1.0)) * told["error"]
    command = command + filtered * told["error_rate"]
    command = command + sum(gains[name] * told[name] for name in signals)
    return np.asarray(told["error"] / (1.0 - command))


def _closed(model: Nominal, gains: LinearGains, sample_time: float, room: float) -> Floats:
    """States: the drive, the filtered rate, the integral where there is one."""
    size, rows = len(model.b), model.outputs
    rate = np.append((1.0 - gains.kept) * rows["error_rate"], [gains.kept, 0.0])
    command = np.append(gains.kp * rows["error"], [0.0, 1.0]) + gains.kd * rate
    integral = np.append(gains.ki * sample_time * rows["error"], [0.0, 1.0])
    a, b = np.zeros((size + 2, size + 2)), np.append(model.b, [0.0, 0.0])
    a[:size, :size], a[size], a[size + 1] = model.a, rate, integral
    states = size + 2 if gains.ki else size + 1
    return (a + np.outer(b, room * command))[:states, :states]
