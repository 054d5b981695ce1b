"""The naive peer: one individual in textbook vectors, then jit(vmap(scan)), JAX as it comes."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from work import INPUTS, UNITS, Constants, Machine, Work


class Individual(NamedTuple):
    """One individual, or a population in the leading axis."""

    kp: Any
    kd: Any
    scales: Any  # (5,)
    sources: Any  # (4, 2)
    consequents: Any  # (4, 7, 7)


def prepare(work: Work, move: Callable[..., Any] | None = None) -> Callable[[], np.ndarray]:
    """A function that scores all individuals, (individuals,).

    ``move(machine, x, voltage, loads, dt)`` is the state (6,) one sample later.
    """
    machine = Machine(*work.machine.tolist())
    constants = Constants(*work.constants.tolist())
    individuals = Individual(*(jnp.asarray(np.moveaxis(leaf, -1, 0)) for leaf in work[:5]))
    rows = tuple(map(jnp.asarray, (work.reference, work.reference_rate, work.loads.T)))
    terms = jnp.asarray(work.terms)

    def score(individual: Individual) -> jax.Array:
        def sample(carry: Any, row: Any) -> Any:
            x, previous, sums = carry
            errors = jnp.stack([row[0] - x[3], row[1] - x[4]])
            inputs = jnp.stack([errors[0], *deflection(machine, x), x[4], previous])
            inputs = jnp.clip(individual.scales * inputs, -1.0, 1.0)
            voltage = individual.kp * errors[0] + individual.kd * errors[1]
            voltage += constants.output_scale * hierarchy(terms, individual, inputs)
            moved = (move or rk4)(machine, x, voltage, row[2], constants.sample_time)
            return (moved, x[4], sums + jnp.abs(errors)), None

        start = (jnp.zeros(6, jnp.float32), jnp.float32(0.0), jnp.zeros(2, jnp.float32))
        (_, _, sums), _ = lax.scan(sample, start, rows)
        weights = jnp.array([constants.error_weight, constants.error_rate_weight], jnp.float32)
        return 1000.0 * jnp.sum(weights / sums)

    population = jax.jit(jax.vmap(score)).lower(individuals).compile()
    return lambda: np.asarray(population(individuals))


def deflection(machine: Machine, x: jax.Array) -> jax.Array:
    """Deflection of the transmission [rad] and its rate [rad/s], (2,)."""
    return x[1:3] - machine.gear_ratio * x[3:5]


def memberships(terms: jax.Array, u: jax.Array) -> jax.Array:
    """Degrees (7,) to which the scalar ``u`` belongs to the terms."""
    centre, half_width, rate = terms
    outside = jnp.maximum(jnp.abs(u - centre) - half_width, 0.0)
    return jnp.exp(-rate * outside**2)


def hierarchy(terms: jax.Array, individual: Individual, inputs: jax.Array) -> jax.Array:
    """Output of the root for the scaled inputs (5,)."""
    values = jnp.concatenate([inputs, jnp.zeros(UNITS, inputs.dtype)])
    for k in range(UNITS):
        column, row = (memberships(terms, u) for u in jnp.take(values, individual.sources[k]))
        weighted = jnp.einsum("i,ij,j->", row, individual.consequents[k], column)
        values = values.at[INPUTS + k].set(weighted / (jnp.sum(row) * jnp.sum(column)))
    return values[-1]


def derivative(m: Machine, x: jax.Array, voltage: Any, load: Any) -> jax.Array:
    """Rates (6,) of the state (6,) under ``voltage`` [V] and ``load`` [N m]."""
    current, _, rotor_velocity, _, spindle_velocity, bristle = x
    spring = m.stiffness * deflection(m, x)[0]
    stribeck = jnp.exp(-((spindle_velocity * m.inverse_stribeck_velocity) ** 2))
    steady = (m.coulomb_torque + m.stribeck_rise * stribeck) / m.bristle_stiffness
    rate = spindle_velocity - jnp.abs(spindle_velocity) * bristle / steady
    friction = m.bristle_stiffness * bristle + m.bristle_damping * rate
    friction += m.viscous_friction * spindle_velocity
    motor = m.torque_constant * current - spring - m.rotor_damping * rotor_velocity
    decay = m.current_decay * current + m.back_emf * rotor_velocity
    return jnp.stack(
        [
            m.inverse_inductance * voltage - decay,
            rotor_velocity,
            m.inverse_rotor_inertia * motor,
            spindle_velocity,
            m.inverse_spindle_inertia * (m.gear_ratio * spring - friction - load),
            rate,
        ]
    )


def rk4(m: Machine, x: jax.Array, voltage: Any, loads: jax.Array, dt: float) -> jax.Array:
    """The state (6,) ``dt`` [s] later, one classical Runge-Kutta step."""
    k1 = derivative(m, x, voltage, loads[0])
    k2 = derivative(m, x + 0.5 * dt * k1, voltage, loads[1])
    k3 = derivative(m, x + 0.5 * dt * k2, voltage, loads[1])
    k4 = derivative(m, x + dt * k3, voltage, loads[2])
    return x + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
