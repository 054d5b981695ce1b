"""The C-axis with free bristles: everything but friction is linear (LL eq. 2).

Friction is ``sigma_0 z + sigma_1 dz/dt + sigma_2 omega``. With the momentum ``p = J_c omega_c +
sigma_1 z`` in place of the velocity, the derivative of ``z`` is eliminated and ``z`` is an input
like the voltage. LuGre's own ``z`` never leaves ``+-T_s / sigma_0``: there ``|omega| sigma_0 |z| /
T_s`` is no less than ``|omega|``, so that it does not grow (Canudas de Wit et al. 1995, property
1). The motion under any controller is one of the motions of this machine with some ``z`` within
bounds.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from hfc_design.core.numbers import Floats
from hfc_design.motion.samples import Samples
from plants.c_axis import CAxisParameters, CAxisState, coefficients

#: Indices of the state: current, rotor angle, rotor velocity, spindle angle, momentum.
STATES, ANGLE, MOMENTUM = 5, 3, 4


class LinearModel(NamedTuple):
    """``dx/dt = a x + voltage v + bristle z + load T``, all in SI units."""

    a: Floats  # (5, 5)
    voltage: Floats  # (5,)
    bristle: Floats  # (5,)
    load: Floats  # (5,)
    inertia: float  # J_c [kg m2]
    damping: float  # sigma_1 [N m s/rad]
    largest: float  # T_s / sigma_0, where z stays [rad]
    sliding: float  # T_c / sigma_0, where it heads for at high speed [rad]
    stribeck: float  # (T_s - T_c) / sigma_0 [rad]
    inverse_velocity: float  # 1 / omega_s [s/rad]

    def steady(self, speed: float) -> float:
        """Return the magnitude of the bristles' deflection at a steady speed [rad] (LL eq. 1g)."""
        return self.sliding + self.stribeck * float(np.exp(-((speed * self.inverse_velocity) ** 2)))


class Sampled(NamedTuple):
    """The linear model from sample to sample, under a held voltage and held bristles."""

    a: Floats  # (5, 5)
    voltage: Floats  # (5,)
    bristle: Floats  # (5,)
    time: float  # [s]


def linear_model(parameters: CAxisParameters) -> LinearModel:
    """Return the linear part of the C-axis (LL eq. 2), with the bristles as an input."""
    c = coefficients(parameters)
    friction, inertia = c.friction, parameters.spindle_inertia
    mass, gear = c.inverse_rotor_inertia, c.gear_ratio
    slope = 1.0 / inertia  # of the velocity, by the momentum
    a = np.zeros((STATES, STATES))
    a[0, [0, 2]] = -c.current_decay, -c.back_emf
    a[1, 2] = 1.0
    spring = c.stiffness * np.array([1.0, -gear])  # by the angles of rotor and spindle
    a[2, [0, 2]] = mass * c.torque_constant, -mass * c.rotor_damping
    a[2, [1, ANGLE]] = -mass * spring
    a[ANGLE, MOMENTUM] = slope
    a[MOMENTUM, [1, ANGLE]] = gear * spring
    a[MOMENTUM, MOMENTUM] = -friction.viscous * slope
    shared = friction.bristle_damping * slope  # velocity = slope p - shared z
    bristle = [0, 0, 0, -shared, friction.viscous * shared - friction.bristle_stiffness]
    return LinearModel(
        a=a,
        voltage=np.array([c.inverse_inductance, 0.0, 0.0, 0.0, 0.0]),
        bristle=np.array(bristle),
        load=np.array([0.0, 0.0, 0.0, 0.0, -1.0]),
        inertia=inertia,
        damping=friction.bristle_damping,
        largest=parameters.static_torque / parameters.bristle_stiffness,
        sliding=parameters.coulomb_torque / parameters.bristle_stiffness,
        stribeck=friction.stribeck_rise / parameters.bristle_stiffness,
        inverse_velocity=friction.inverse_stribeck_velocity,
    )


def sampled(machine: LinearModel, time: float) -> Sampled:
    """Return the exact model for samples of ``time`` [s]: a matrix exponential with held inputs."""
    whole = np.zeros((STATES + 2, STATES + 2))
    whole[:STATES] = np.column_stack([machine.a, machine.voltage, machine.bristle])
    transition = expm(whole * time)[:STATES]
    return Sampled(transition[:, :STATES], transition[:, STATES], transition[:, STATES + 1], time)


def undriven(machine: LinearModel, samples: Samples, substeps: int, start: CAxisState) -> Floats:
    """Return the states (steps, 5) at all samples without voltage and bristles, under the load.

    Within a substep the load is the parabola through the three values that the integrator takes.
    """
    time = float(samples.sample_time) / substeps
    whole = np.zeros((STATES + 3, STATES + 3))  # state, load, its slope, its bend
    whole[:STATES, :STATES], whole[:STATES, STATES] = machine.a, machine.load
    whole[STATES, STATES + 1] = whole[STATES + 1, STATES + 2] = 1.0 / time  # in substeps
    transition = expm(whole * time)[:STATES]
    loads = np.asarray(samples.axes[0].loads)
    x = np.array([*start[:ANGLE], start.spindle_angle, 0.0])
    x[MOMENTUM] = machine.inertia * start.spindle_velocity
    x[MOMENTUM] += machine.damping * start.bristle_deflection
    states = np.empty((loads.shape[1], STATES))
    for k, load in enumerate(loads.T):
        states[k] = x
        for first, middle, last in zip(load[:-1:2], load[1::2], load[2::2], strict=True):
            bend = 4.0 * (first + last - 2.0 * middle)  # second derivative of the parabola
            slope = 4.0 * middle - 3.0 * first - last
            x = transition @ np.array([*x, first, slope, bend])
    return states
