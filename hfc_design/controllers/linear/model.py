"""What a nominal drive tells of linear gains: optimal ones, what is fed forward, the loop."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.linear.law import LinearGains
from hfc_design.controllers.linear.record import MULTIPLES, LinearDesign
from hfc_design.core.numbers import Floats, Parameters, Scalar
from hfc_design.core.records import UserError
from hfc_design.stability.margins import OpenLoop
from hfc_design.stability.nominal import Nominal, nominal
from plants import Drive

#: Doublings of the horizon; the slowest closed loop that is found settles within 2^DOUBLINGS.
DOUBLINGS = 40
#: Change [1] at which a Riccati equation is solved, and its largest residual.
SOLVED, RESIDUAL = 1e-14, 1e-6
#: Share of a signal that no other one tells, so that it counts as a state of its own.
OWN_SHARE = 1e-6
#: Bandwidths that are tried, in shares of one over the sample time.
BANDWIDTHS = (1e-3, 0.5)
#: How much slower the integral of a first controller is than its loop.
INTEGRAL = 0.1
#: Weight of the error's rate of a first regulator, in shares of the gain kd of a PID.
RATE = 0.1
#: Factors on the loop gain at which the first controller is stable too.
ROOM = (0.5, 1.0, 2.0)


class Measured(NamedTuple):
    """The nominal drive by what its sensors tell: ``y(k+1) = a y + b u``.

    What they do not tell (the bristles of friction) is taken for settled.
    """

    names: tuple[str, ...]  # of the states: error, error_rate, signals
    a: Floats
    b: Floats

    def with_integral(self, sample_time: float) -> "Measured":
        """The integral of the error in front, of the samples before this one."""
        size = len(self.b)
        a = np.block([[np.ones((1, 1)), np.zeros((1, size))], [np.zeros((size, 1)), self.a]])
        a[0, 1] = sample_time
        return Measured(("integral", *self.names), a, np.append(0.0, self.b))


def measured(model: Nominal, names: Sequence[str] | None, told: str) -> Measured:
    """The model in these signals, or in all that tell something that no other one does.

    Raises:
        UserError: one of ``names`` follows from the others; ``told`` says whose they are.
    """
    rows: list[Floats] = []
    kept: list[str] = []
    for name in ["error", "error_rate", *(model.outputs if names is None else names)]:
        row = model.outputs[name]
        before = np.linalg.qr(np.array(rows).T)[0] if rows else np.zeros((len(row), 0))
        own = row - before @ (before.T @ row)
        if np.linalg.norm(own) > OWN_SHARE * np.linalg.norm(row):
            rows.append(row)
            kept.append(name)
        elif names and name in names:
            raise UserError(f"controller.signals: {name!r} of the {told} follows from the others")
    seen = np.array(rows)
    rest = np.linalg.svd(seen)[2][len(seen) :]
    turn = np.concatenate([seen, rest])
    a, b = turn @ model.a @ np.linalg.inv(turn), turn @ model.b
    here, there = slice(len(seen)), slice(len(seen), None)
    settled = np.linalg.solve(
        np.eye(len(rest)) - a[there, there], np.column_stack([a[there, here], b[there]])
    )
    a, b = (
        a[here, here] + a[here, there] @ settled[:, :-1],
        b[here] + a[here, there] @ settled[:, -1],
    )
    return Measured(tuple(kept), a, b)


def regulators(model: Measured, weights: Floats, scale: Floats | None = None) -> Floats:
    """(n, states) gains ``u = k y`` that minimise sum u^2 + (w y)^2, for n rows of weights.

    A population of discrete Riccati equations at once, by the structure-preserving doubling
    algorithm (Chu, Fan, Lin and Wang, Int. J. Control 77, 2004); nan where there is no solution.
    ``scale`` is about as large as the gains are.
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
    """Solutions, nan where a matrix is singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, right), float)
    except np.linalg.LinAlgError:
        each = zip(matrices, right, strict=True)
        return np.array([_or_nan(*pair) for pair in each])


def _or_nan(matrix: Floats, right: Floats) -> Floats:
    try:
        return np.asarray(np.linalg.solve(matrix, right), float)
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)


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
        loops = (_loop(model, gains, sample_time, room) for room in ROOM)
        stable = all(abs(np.linalg.eigvals(x.a + np.outer(x.b, x.c))).max() < 1.0 for x in loops)
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


def first_regulators(model: Measured, kp: Floats, kd: Floats) -> dict[str, Floats]:
    """Gains (n,) of regulators with the weights of a PD on error and its rate alone.

    Raises:
        UserError: there is none.
    """
    weights = np.zeros((len(kp), len(model.b)))
    weights[:, 0], weights[:, 1] = kp, RATE * kd
    found = regulators(model, weights)
    if not np.isfinite(found).all():
        raise UserError("controller: no optimal regulator of this drive was found")
    return dict(zip(model.names, found.T, strict=True))


def open_loop(record: LinearDesign, drive: Drive, parameters: Parameters) -> OpenLoop:
    """The loop of a design on a drive, near the speed where that slides.

    Raises:
        UserError: the drive cannot be linearised, or does not tell a signal.
    """
    every = record.sample_time_s
    model = nominal(drive, parameters, every)
    for name in record.signals:
        if name not in model.outputs:
            raise UserError(f"controller.signals: {name!r} is no signal of the {drive.name}")
    return _loop(model, record.gains(), every, 1.0, tuple(record.signals))


def _loop(
    model: Nominal, gains: LinearGains, sample_time: float, room: float, names: Sequence[str] = ()
) -> OpenLoop:
    """States are those of the drive, the filtered rate, the integral where there is one."""
    size, rows = len(model.b), model.outputs
    fed_back = sum(
        (gain * rows[name] for name, gain in zip(names, gains.signals or (), strict=True)),
        np.zeros(size),
    )
    rate = np.append((1.0 - gains.kept) * rows["error_rate"], [gains.kept, 0.0])
    command = np.append(gains.kp * rows["error"] + fed_back, [0.0, 1.0]) + gains.kd * rate
    integral = np.append(gains.ki * sample_time * rows["error"], [0.0, 1.0])
    a, b = np.zeros((size + 2, size + 2)), np.append(model.b, [0.0, 0.0])
    a[:size, :size], a[size], a[size + 1] = model.a, rate, integral
    states = size + 2 if gains.ki else size + 1
    return OpenLoop(a[:states, :states], b[:states], room * command[:states])
