"""Feed-forward of a nominal drive, a first PID, and optimal regulators for a population."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.linear.law import LinearGains
from hfc_design.controllers.linear.record import MULTIPLES, resonator_name
from hfc_design.core.numbers import Floats, Scalar
from hfc_design.core.records import UserError
from hfc_design.stability.nominal import Nominal

#: Smallest and largest bandwidth that are tried, in units of 1 / sample time.
BANDWIDTHS = (1e-3, 0.5)
#: Ratio ki / kp of a first PID, as a share of its bandwidth.
INTEGRAL = 0.1
#: Factors on the loop gain with which a first PID must be stable.
ROOM = (0.5, 1.0, 2.0)
#: Doublings of the horizon; the slowest closed loop found settles within 2^DOUBLINGS samples.
DOUBLINGS = 40
#: Relative change at which a Riccati equation counts as solved, and largest relative residual.
SOLVED, RESIDUAL = 1e-14, 1e-6
#: A signal is a state of its own if more than this share of it is independent of other states.
OWN_SHARE = 1e-6
#: Suffix of a resonator's name for its second state.
BEHIND = "_behind"
#: Weight of the error's rate in a first regulator, in shares of kd of a first PID.
RATE = 0.1
#: Smallest gain of a first regulator, in shares of its kp, because ranges need a size.
SMALLEST = 1e-12


class Measured(NamedTuple):
    """Linear model of a drive whose states are signals: ``y(k+1) = a y + b u``, u the command.

    States of the drive that are not measured (bristles of friction) are assumed to be settled.
    """

    names: tuple[str, ...]  # of the states: error, error_rate, signals
    a: Floats  # (states, states)
    b: Floats  # (states,)

    def with_integral(self, sample_time: float) -> "Measured":
        """Return the model with the integral of the previous samples' error as first state."""
        size = len(self.b)
        a = np.block([[np.ones((1, 1)), np.zeros((1, size))], [np.zeros((size, 1)), self.a]])
        a[0, 1] = sample_time
        return Measured(("integral", *self.names), a, np.append(0.0, self.b))

    def with_resonators(self, angles: Sequence[float], sample_time: float) -> "Measured":
        """Return the model with added resonators of ``angles`` [rad a sample], driven by the error.

        Each has two states; those of the first are ``resonator_1`` and ``resonator_1_behind``.
        """
        size, names = len(self.b), list(self.names)
        whole = size + 2 * len(angles)
        a, b = np.zeros((whole, whole)), np.append(self.b, np.zeros(2 * len(angles)))
        a[:size, :size] = self.a
        for k, angle in enumerate(angles):
            first, name = size + 2 * k, resonator_name(k)
            cosine, sine = np.cos(angle), np.sin(angle)
            a[first : first + 2, first : first + 2] = [[cosine, sine], [-sine, cosine]]
            a[first, names.index("error")] = sample_time
            names += [name, name + BEHIND]
        return Measured(tuple(names), a, b)


def measured(model: Nominal, names: Sequence[str] | None, drive_name: str) -> Measured:
    """Return the model with the states error, error_rate and ``names``; None: all independent ones.

    Raises:
        UserError: one of ``names`` follows from other states; the message has ``drive_name``.
    """
    rows: list[Floats] = []
    independent: list[str] = []
    for name in ["error", "error_rate", *(model.outputs if names is None else names)]:
        row = model.outputs[name]
        before = np.linalg.qr(np.array(rows).T)[0] if rows else np.zeros((len(row), 0))
        residual = row - before @ (before.T @ row)
        if np.linalg.norm(residual) > OWN_SHARE * np.linalg.norm(row):
            rows.append(row)
            independent.append(name)
        elif names and name in names:
            fault = f"{name!r} of the {drive_name} is a combination of the others"
            raise UserError(f"controller.signals: {fault}; leave it out")
    seen = np.array(rows)
    rest = np.linalg.svd(seen)[2][len(seen) :]
    turn = np.concatenate([seen, rest])
    a, b = turn @ model.a @ np.linalg.inv(turn), turn @ model.b
    here, there = slice(len(seen)), slice(len(seen), None)
    driven, rests = np.column_stack([a[there, here], b[there]]), a[here, there]
    settled = np.linalg.solve(np.eye(len(rest)) - a[there, there], driven)
    whole = a[here, here] + rests @ settled[:, :-1], b[here] + rests @ settled[:, -1]
    return Measured(tuple(independent), *whole)


def regulators(model: Measured, weights: Floats, scale: Floats | None = None) -> Floats:
    """Return gains k (n, states) of ``u = k y`` that minimise the sum of u^2 + (w y)^2.

    ``weights`` w are (n, states); ``scale`` (states,) is the approximate size of the gains. All n
    discrete Riccati equations are solved at once, by the structure-preserving doubling algorithm
    (Chu, Fan, Lin and Wang, Int. J. Control 77, 2004). Gains are nan if no solution is found.
    """
    size = len(model.b)
    unit = np.ones(size) if scale is None else scale
    one = np.eye(size)
    a = np.broadcast_to(model.a * unit[:, None] / unit, (len(weights), size, size))
    b = (model.b * unit)[:, None]
    cost = (weights / unit)[:, :, None] ** 2 * one
    with np.errstate(all="ignore"):
        power, control, value = a, np.broadcast_to(b @ b.T, a.shape), cost
        for _ in range(DOUBLINGS):
            inner = _solved(one + control @ value, np.concatenate([power, control], axis=2))
            ahead, turned = inner[..., :size], np.swapaxes(power, 1, 2)
            more = turned @ value @ ahead
            control = control + power @ inner[..., size:] @ turned
            value, power = value + more, power @ ahead
            if not (abs(more).max((1, 2)) > SOLVED * abs(value).max((1, 2))).any():
                break
        gain = (b.T @ value @ a) / (1.0 + b.T @ value @ b)
        left = cost + np.swapaxes(a, 1, 2) @ value @ (a - b @ gain) - value
        wrong = ~(abs(left).max((1, 2)) <= RESIDUAL * abs(value).max((1, 2)))
    return np.where(wrong[:, None], np.nan, -gain[:, 0] * unit)


def _solved(matrices: Floats, right: Floats) -> Floats:
    """Return the solutions of linear systems, nan where a matrix is singular."""
    singular = np.linalg.det(matrices) == 0.0
    whole = np.where(singular[:, None, None], np.nan, matrices)
    return np.asarray(np.linalg.solve(whole, right), float)


def first_regulators(model: Measured, kp: Floats, kd: Floats) -> dict[str, Floats]:
    """Return gains (n,) by state of regulators that weight only the error and the error's rate.

    The weights are kp and a share of kd. No gain is 0, because search ranges follow from them.

    Raises:
        UserError: no regulator was found.
    """
    weights = np.zeros((len(kp), len(model.b)))
    weights[:, 0], weights[:, 1] = kp, RATE * kd
    gains = regulators(model, weights)
    if not np.isfinite(gains).all():
        raise UserError("controller: found no optimal regulator of this drive")
    small = SMALLEST * np.abs(gains[:, :1])
    gains = np.where(np.abs(gains) < small, small, gains)
    return dict(zip(model.names, gains.T, strict=True))


def ahead(model: Nominal, signals: dict[str, Floats]) -> dict[str, Floats]:
    """Return feed-forward by name: what the drive needs, less what gains on ``signals`` give."""
    forward = {}
    for name in MULTIPLES:
        steady = getattr(model, name)
        feedback = sum(gain * (model.outputs[key] @ steady.state) for key, gain in signals.items())
        forward[name] = steady.command - feedback
    return forward


def bandwidth(model: Nominal, sample_time: float) -> float:
    """Return the largest bandwidth [1/s] of a PID stable with ``ROOM``, else the smallest."""
    best = 0.0
    for speed in np.geomspace(*BANDWIDTHS, 55) / sample_time:
        gains = LinearGains(*map(float, pid(model, speed)))
        closed = (_closed(model, gains, sample_time, room) for room in ROOM)
        stable = all(abs(np.linalg.eigvals(loop)).max() < 1.0 for loop in closed)
        if stable or not best:
            best = float(speed)
    return best


def pid(model: Nominal, speed: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Return kp, ki, kd for a bandwidth ``speed`` [1/s].

    With kp and kd, a drive ``mass s^2 + drag s`` has the poles -speed and -(speed + drag / mass).
    """
    mass, drag = abs(model.acceleration.command), abs(model.velocity.command)
    kp = mass * speed**2 + drag * speed
    return kp, INTEGRAL * speed * kp, 2.0 * mass * speed


def answer(
    model: Nominal, gains: dict[str, Floats], signals: Sequence[str], z: complex, sample_time: float
) -> Floats:
    """Return the complex error (n,) that an added command of 1 at ``z`` causes in a PID's loop.

    ``gains`` are kp, ki, kd, filter_pole and the gains on ``signals``, each (n,).
    """
    state = np.linalg.solve(z * np.eye(len(model.b)) - model.a, model.b)
    responses = {name: row @ state for name, row in model.outputs.items()}
    filtered = gains["kd"] * (1.0 - gains["filter_pole"]) * z / (z - gains["filter_pole"])
    command = (gains["kp"] + gains["ki"] * sample_time / (z - 1.0)) * responses["error"]
    command = command + filtered * responses["error_rate"]
    command = command + sum(gains[name] * responses[name] for name in signals)
    return np.asarray(responses["error"] / (1.0 - command))


def _closed(model: Nominal, gains: LinearGains, sample_time: float, room: float) -> Floats:
    """Return the matrix of a PID's closed loop: states of drive, filtered rate and any integral."""
    size, rows = len(model.b), model.outputs
    rate = np.append((1.0 - gains.filter_pole) * rows["error_rate"], [gains.filter_pole, 0.0])
    command = np.append(gains.kp * rows["error"], [0.0, 1.0]) + gains.kd * rate
    integral = np.append(gains.ki * sample_time * rows["error"], [0.0, 1.0])
    a, b = np.zeros((size + 2, size + 2)), np.append(model.b, [0.0, 0.0])
    a[:size, :size], a[size], a[size + 1] = model.a, rate, integral
    states = size + 2 if gains.ki else size + 1
    return (a + np.outer(b, room * command))[:states, :states]
