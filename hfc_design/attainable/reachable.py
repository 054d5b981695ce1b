"""Largest reachable states for any voltage: bristles bend no further than the spindle moves.

``d|z|/dt <= |omega|``, so ``|z|`` grows by at most the distance travelled; in the first samples
this bound is smaller than the largest deflection of the friction model, T_s / sigma_0.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from hfc_design.attainable.linear_model import MOMENTUM, STATES, LinearModel, Sampled
from hfc_design.core.numbers import Floats

#: Largest magnitude of a parabola through three values, relative to the largest of them.
PARABOLA = 1.25


class Reachable(NamedTuple):
    """The largest magnitudes within each sample."""

    states: Floats  # (steps, 5)
    bristles: Floats  # (steps,) of z [rad]
    speed: Floats  # (steps,) of the spindle [rad/s]
    bending: Floats  # (steps,) second derivative of the momentum [N m/s]


def reachable(
    machine: LinearModel,
    one: Sampled,
    moved: Floats,
    loads: Floats,
    voltage: Floats,
    bent: float = 0.0,
) -> Reachable:
    """Return the largest magnitudes for voltages of at most ``voltage`` (steps,), nondecreasing.

    ``moved`` (steps + 1, 5) are the states without voltage and bristles, ``loads`` (2 substeps + 1,
    steps + 1) are as in ``Samples``, ``bent`` is ``|z|`` at the start. Every speed is bounded by
    the largest so far, every ``|z|`` within a sample by that at the end of the sample.
    """
    steps, slope = len(voltage), 1.0 / machine.inertia
    shared, allowed = machine.damping * slope, max(machine.largest, bent)
    by_voltage = _answers(machine, one, machine.voltage, steps)
    by_bristles = _answers(machine, one, machine.bristle, steps)
    drift = _drift(machine, one, moved, loads)
    share = slope * by_bristles[0, MOMENTUM] + shared  # speed for a unit of |z| at a sample's end
    left = 1.0 - one.time * share
    speed, way, bristles = 0.0, bent, np.full(steps, allowed)
    for k in range(steps):
        past = by_voltage[: k + 1, MOMENTUM] @ voltage[k::-1]
        past += by_bristles[1 : k + 1, MOMENTUM] @ bristles[:k][::-1]
        base_speed = slope * (drift[k, MOMENTUM] + past) + share * way
        speed = max(speed, base_speed / left) if left > 0.0 else np.inf
        way += one.time * speed
        if not way < allowed:
            break
        bristles[k] = way
    states = drift + _convolved(by_voltage, voltage) + _convolved(by_bristles, bristles)
    speeds = slope * states[:, MOMENTUM] + shared * bristles
    bending = _bending(machine, one, states, loads, voltage, bristles)
    return Reachable(states, bristles, speeds, bending)


def _answers(machine: LinearModel, one: Sampled, given: Floats, steps: int) -> Floats:
    """Return bounds (steps, 5) of the integral of the impulse response's magnitude in each sample.

    They are the trapezoidal rule plus a bound of its error (see ``certificate``).
    """
    x, ends = np.array(given), np.empty((steps + 1, STATES))
    for k in range(steps + 1):
        ends[k] = x
        x = one.a @ x
    ends = np.abs(ends)
    within = np.abs(machine.a @ machine.a) @ expm(np.abs(machine.a) * one.time)
    return 0.5 * one.time * (ends[:-1] + ends[1:]) + one.time**3 / 12.0 * (ends[:-1] @ within.T)


def _convolved(answers: Floats, given: Floats) -> Floats:
    """Return the convolution (steps, 5) of responses (steps, 5) with the input (steps,)."""
    columns = [np.convolve(column, given)[: len(given)] for column in answers.T]
    return np.column_stack(columns)


def _drift(machine: LinearModel, one: Sampled, moved: Floats, loads: Floats) -> Floats:
    """Return the largest magnitudes (steps, 5) within each sample, without voltage and bristles."""
    most = PARABOLA * np.abs(loads).max(axis=0)
    rates = np.abs(moved) @ np.abs(machine.a).T + np.outer(most, np.abs(machine.load))
    ends = np.abs(moved) + one.time * rates
    return np.maximum(ends[:-1], ends[1:])


def _bending(
    machine: LinearModel,
    one: Sampled,
    states: Floats,
    loads: Floats,
    voltage: Floats,
    bristles: Floats,
) -> Floats:
    """Return bounds (steps,) of the second derivative of the momentum [N m/s]."""
    most = PARABOLA * np.abs(loads).max(axis=0)[:-1]
    rates = states @ np.abs(machine.a).T
    pairs = (voltage, machine.voltage), (bristles, machine.bristle), (most, machine.load)
    for given, by in pairs:
        rates += np.outer(given, np.abs(by))
    speed = states[:, MOMENTUM] / machine.inertia + bristles * machine.damping / machine.inertia
    bent = speed * (1.0 + bristles / machine.sliding)
    change = 3.0 * np.abs(np.diff(loads, axis=0)).max(axis=0)[:-1]  # of a parabola in half a step
    rising = change * (len(loads) - 1) / one.time
    return rates @ np.abs(machine.a[MOMENTUM]) + abs(machine.bristle[MOMENTUM]) * bent + rising
