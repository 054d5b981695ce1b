"""The best voltage that is found with everything known beforehand: an error that can be reached.

The head of the motion, where the voltage is at its limit, is solved by linear programmes along the
motion itself, with friction: each minimises the sum of errors for small changes, and is accepted
if the simulator confirms it. The rest, where errors can be close to zero, is solved by Gauss-Newton
steps: linear regulators along the motion (Li & Todorov 2004). They also keep the motion on its
course if a converter rounds the voltage.
"""

import numpy as np

from hfc_design.attainable.linear_program import Linear, linear_program
from hfc_design.attainable.rollout import RolledOut, Rollout, answers, rolled_out
from hfc_design.core.numbers import Floats
from plants.c_axis import CAxisState

#: Programmes along the head, and their first and last trust region [share of the limit].
ROUNDS, TRUST, LEAST_TRUST = 24, 0.5, 1e-3
#: A round or step that lowers the sum by a smaller share is the last.
GAIN = 1e-3
#: Sums below this count as zero.
TINY = float(np.finfo(np.float64).tiny)
#: Samples of the head that are left to the rest, since the end of a programme is arbitrary.
OVERLAP = 32
#: Most Gauss-Newton steps; first and least cost of a change of a volt beside an error of a radian.
SWEEPS, COST, LEAST_COST = 16, 1e-9, 1e-13
#: Costs that are tried for the regulators that counteract the rounding of a converter.
COSTS = (1e-8, 1e-9, 1e-10, 1e-11, 1e-12)


def best_voltage(one: Rollout, first: Floats, largest: Floats) -> RolledOut:
    """Return a motion with a small ``sum |e|``, from a ``first`` voltage (samples,) of its head.

    ``largest`` (steps,) is the limit of the voltage in each sample of the whole motion.
    """
    smooth = one._replace(resolution=None)
    motion = _head(smooth, first, largest)
    head_length = len(largest)
    if len(motion.voltage) < head_length:
        head_length = max(len(motion.voltage) - OVERLAP, 1)
        motion = _rest(smooth, motion, head_length)
    still = rolled_out(one, np.zeros(len(largest)))  # no voltage may be best
    if not one.resolution:
        return min(motion, still, key=_sum)
    system, candidates = answers(one, motion.voltage, motion.states), [still]
    for cost in COSTS:  # the higher the cost, the less the gain reacts to a single rounding
        gain, _ = _regulator(system, motion.error, cost, 1)
        candidates.append(rolled_out(one, motion.voltage, (motion.states, gain)))
    return min(candidates, key=_sum)


def _rest(one: Rollout, head: RolledOut, head_length: int) -> RolledOut:
    """Return the whole motion; its first ``head_length`` samples are those of ``head``."""
    voltage, states = _quasi_static(one)
    gain, _ = _regulator(answers(one, voltage, states), np.zeros(len(voltage)), COST, head_length)
    voltage[:head_length] = head.voltage[:head_length]
    best, cost = rolled_out(one, voltage, (states, gain)), COST
    for _ in range(SWEEPS):
        system = answers(one, best.voltage, best.states)
        gain, change = _regulator(system, best.error, cost, head_length)
        tried = rolled_out(one, best.voltage + change, (best.states, gain))
        share = _sum(tried) / max(_sum(best), TINY)
        best = min(best, tried, key=_sum)
        cost = max(0.1 * cost, LEAST_COST) if share < 1.0 else 30.0 * cost
        if 1.0 - GAIN < share <= 1.0:
            break
    return best


def _sum(motion: RolledOut) -> float:
    total = float(np.abs(motion.error).sum())
    return total if np.isfinite(total) else np.inf


def _head(one: Rollout, voltage: Floats, largest: Floats) -> RolledOut:
    """Return the first samples (as many as in ``voltage``), improved by linear programmes."""
    motion, trust = rolled_out(one, voltage), TRUST
    most, whole = largest[: len(voltage)], float(largest.max())
    for _ in range(ROUNDS):
        now = motion.voltage
        low = np.maximum(-most, now - trust * whole) - now
        high = np.minimum(most, now + trust * whole) - now
        system = answers(one, now, motion.states)
        linear = Linear(system.a[:-1], system.b[:-1], system.output)
        bounds = low[:-1, None], high[:-1, None]
        change = linear_program(linear, motion.error[1:], *bounds).least_sum()
        if change is None:
            break
        tried = rolled_out(one, now + np.append(change.inputs[:, 0], 0.0))
        better = 1.0 - _sum(tried) / max(_sum(motion), TINY)
        motion = min(motion, tried, key=_sum)
        trust *= 2.0 if better > GAIN else 0.25
        if 0.0 <= better <= GAIN or trust < LEAST_TRUST:
            break
    return motion


def _quasi_static(one: Rollout) -> tuple[Floats, Floats]:
    """Return quasi-static voltages (steps,) and states (steps, 6) of the motion (LL eq. 2)."""
    happens, (c,) = one.samples.axes[0], one.fixed
    place, speed = np.asarray(happens.target), np.asarray(happens.reference_rate)
    stribeck = np.exp(-((speed * c.friction.inverse_stribeck_velocity) ** 2))
    sliding = np.sign(speed) * (c.friction.coulomb + c.friction.stribeck_rise * stribeck)
    torque = sliding + c.friction.viscous * speed + np.asarray(happens.loads)[0]
    spring, turning = torque / c.gear_ratio, c.gear_ratio * speed
    current = (spring + c.rotor_damping * turning) / c.torque_constant
    voltage = (c.current_decay * current + c.back_emf * turning) / c.inverse_inductance
    states = CAxisState(
        current=current,
        rotor_angle=c.gear_ratio * place + spring / c.stiffness,
        rotor_velocity=turning,
        spindle_angle=place,
        spindle_velocity=speed,
        bristle_deflection=sliding / c.friction.bristle_stiffness,
    )
    return voltage, np.column_stack(states)


def _regulator(system: Linear, error: Floats, cost: float, begin: int) -> tuple[Floats, Floats]:
    """Return gains (steps, states), changes (steps,) that minimise ``sum e^2 + cost sum dv^2``."""
    steps, states = system.b.shape[:2]
    gain, change = np.zeros((steps, states)), np.zeros(steps)
    weight, slope = np.zeros((states, states)), np.zeros(states)
    counted = np.zeros((states, states))
    counted[system.output, system.output] = 1.0
    for k in range(steps - 1, begin - 1, -1):
        a, b = system.a[k], system.b[k, :, 0]
        pushed = weight @ b
        whole = cost + b @ pushed
        gain[k] = (pushed @ a) / whole
        change[k] = -(b @ slope) / whole
        left = a - np.outer(b, gain[k])
        slope = left.T @ slope
        slope[system.output] -= error[k]
        weight = left.T @ weight @ left + cost * np.outer(gain[k], gain[k]) + counted
    return gain, change
