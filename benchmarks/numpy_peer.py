"""A plain numpy loop over the samples, vectorised over the population."""

from collections.abc import Callable
from typing import Any

import numpy as np
from work import INPUTS, UNITS, Constants, Machine, Work


def prepare(work: Work) -> Callable[[], np.ndarray]:
    """A function that scores all individuals, (individuals,)."""
    machine = Machine(*work.machine.tolist())
    constants = Constants(*work.constants.tolist())
    individuals = work.kp.size
    rows = work.reference.tolist(), work.reference_rate.tolist(), work.loads.T.tolist()

    def run() -> np.ndarray:
        x = np.zeros((6, individuals), np.float32)
        values = np.zeros((INPUTS + UNITS, individuals), np.float32)
        previous = np.zeros(individuals, np.float32)
        error_sum, error_rate_sum = np.zeros((2, individuals), np.float32)
        for reference, reference_rate, loads in zip(*rows, strict=True):
            error, error_rate = reference - x[3], reference_rate - x[4]
            deflection = x[1:3] - machine.gear_ratio * x[3:5]
            inputs = np.stack([error, *deflection, x[4], previous])
            values[:INPUTS] = np.clip(work.scales * inputs, -1.0, 1.0)
            voltage = work.kp * error + work.kd * error_rate
            voltage += constants.output_scale * hierarchy(work, values)
            error_sum += np.abs(error)
            error_rate_sum += np.abs(error_rate)
            previous = x[4]
            x = rk4(machine, x, voltage, loads, constants.sample_time)
        weighted = constants.error_weight / error_sum
        return 1000.0 * (weighted + constants.error_rate_weight / error_rate_sum)

    return run


def hierarchy(work: Work, values: np.ndarray) -> np.ndarray:
    """Output (individuals,) of the root; fills the units' rows of ``values``."""
    everyone = np.arange(values.shape[1])
    for k in range(UNITS):
        column = memberships(work.terms, values[work.sources[k, 0], everyone])
        row = memberships(work.terms, values[work.sources[k, 1], everyone])
        inner = np.einsum("ijn,jn->in", work.consequents[k], column)
        weighted = np.einsum("in,in->n", row, inner)
        values[INPUTS + k] = weighted / (row.sum(axis=0) * column.sum(axis=0))
    return values[-1]


def memberships(terms: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Degrees (7, individuals) of ``u`` (individuals,)."""
    centre, half_width, rate = terms[:, :, None]
    outside = np.maximum(np.abs(u - centre) - half_width, 0.0)
    return np.exp(-rate * outside**2)


def derivative(m: Machine, x: np.ndarray, voltage: np.ndarray, load: float) -> np.ndarray:
    """Rates (6, individuals) of the states under ``voltage`` [V] and ``load`` [N m]."""
    current, rotor_angle, rotor_velocity, spindle_angle, spindle_velocity, bristle = x
    spring = m.stiffness * (rotor_angle - m.gear_ratio * spindle_angle)
    stribeck = np.exp(-((spindle_velocity * m.inverse_stribeck_velocity) ** 2))
    steady = (m.coulomb_torque + m.stribeck_rise * stribeck) / m.bristle_stiffness
    rate = spindle_velocity - np.abs(spindle_velocity) * bristle / steady
    friction = m.bristle_stiffness * bristle + m.bristle_damping * rate
    friction += m.viscous_friction * spindle_velocity
    motor = m.torque_constant * current - spring - m.rotor_damping * rotor_velocity
    rates = np.empty_like(x)
    rates[0] = m.inverse_inductance * voltage - m.current_decay * current
    rates[0] -= m.back_emf * rotor_velocity
    rates[1] = rotor_velocity
    rates[2] = m.inverse_rotor_inertia * motor
    rates[3] = spindle_velocity
    rates[4] = m.inverse_spindle_inertia * (m.gear_ratio * spring - friction - load)
    rates[5] = rate
    return rates


def rk4(m: Machine, x: np.ndarray, voltage: np.ndarray, loads: Any, dt: float) -> np.ndarray:
    """The states (6, individuals) ``dt`` [s] later, one classical Runge-Kutta step."""
    k1 = derivative(m, x, voltage, loads[0])
    k2 = derivative(m, x + 0.5 * dt * k1, voltage, loads[1])
    k3 = derivative(m, x + 0.5 * dt * k2, voltage, loads[1])
    k4 = derivative(m, x + dt * k3, voltage, loads[2])
    return x + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
