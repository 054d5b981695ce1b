"""What a nominal drive tells of linear gains: what is fed forward, a first PID, the loop."""

from collections.abc import Sequence

import numpy as np

from hfc_design.controllers.linear.law import LinearGains
from hfc_design.controllers.linear.record import MULTIPLES, LinearDesign
from hfc_design.core.numbers import Floats, Parameters, Scalar
from hfc_design.core.records import UserError
from hfc_design.stability.margins import OpenLoop
from hfc_design.stability.nominal import Nominal, nominal
from plants import Drive

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


def open_loop(record: LinearDesign, drive: Drive, parameters: Parameters) -> OpenLoop:
    """The loop of a design on a drive, near the speed where that slides.

    Raises:
        UserError: the drive cannot be linearised, or does not tell a signal.
    """
    return loop_of(record, nominal(drive, parameters, record.sample_time_s), drive)


def loop_of(record: LinearDesign, model: Nominal, drive: Drive, key: str = "signals") -> OpenLoop:
    """The loop of a design with a ``model`` of its drive.

    Raises:
        UserError: the drive does not tell a signal of those that the file has under ``key``.
    """
    for name in record.signals:
        if name not in model.outputs:
            raise UserError(f"controller.{key}: {name!r} is no signal of the {drive.name}")
    names = tuple(record.signals)
    return _loop(model, record.gains(), record.sample_time_s, 1.0, names)


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
