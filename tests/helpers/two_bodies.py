"""The milling table's axis by SciPy: from corner to corner of its forces, each part smooth.

Written from the equations and not from the plant: spring ``k dead_zone(d + c/k dd/dt)``, Coulomb
friction at both bodies, at the table with Stribeck's rise.
"""

from math import exp, pi
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp


class Axis(NamedTuple):
    """The parameters as the table meets them [N, mm, s]."""

    motor: float
    motor_damping: float
    motor_friction: float
    gain: float  # [N/V]
    table: float
    viscous: float
    coulomb: float
    rise: float
    stribeck: float
    stiffness: float
    damping: float
    gap: float

    @classmethod
    def of(cls, p):
        turn = 2 * pi / p.lead
        return cls(
            1e3 * p.motor_inertia * turn**2,
            1e3 * p.motor_damping * turn**2,
            1e3 * p.motor_friction * turn,
            1e3 * p.torque_gain * turn,
            p.table_mass / 1e3,
            p.viscous_friction,
            p.coulomb_friction,
            p.stiction_rise,
            p.stribeck_velocity,
            p.stiffness,
            p.damping,
            p.backlash,
        )

    def reach(self, x):
        """What the dead zone is taken of [mm]; x: position, velocity, those of the motor."""
        return x[2] - x[0] + self.damping / self.stiffness * (x[3] - x[1])

    def edge(self, side):
        """What is 0 where a flank begins to touch."""
        return lambda t, x: self.reach(x) - side * self.gap / 2

    def spring(self, x):
        """Force on the table [N]."""
        reach, half = self.reach(x), self.gap / 2
        return self.stiffness * (reach - min(max(reach, -half), half))

    def slides(self, speed):
        """Friction of the slides [N] without its viscous part."""
        return self.coulomb + self.rise * exp(-((speed / self.stribeck) ** 2))


def direction(speed, force, level):
    """Where a body slides, 0 where it sticks."""
    return np.sign(speed) if speed else (np.sign(force) if abs(force) > level else 0.0)


def reference(p, start, voltage, load, times):
    """(times, 4) position, velocity and those of the motor, under constant voltage and load."""
    axis, x, now = Axis.of(p), np.array(start, float), 0.0
    found, nudge = np.empty((len(times), 4)), 1e-12
    flank = int(np.sign(axis.spring(x)))  # that touches, 0 in the gap
    while now < times[-1]:
        forces = axis.gain * voltage - axis.spring(x), axis.spring(x) - load
        one = direction(x[3], forces[0], axis.motor_friction)
        two = direction(x[1], forces[1], axis.slides(0.0))

        def rate(t, x, one=one, two=two):
            spring = axis.spring(x)
            push = axis.gain * voltage - spring - axis.motor_damping * x[3]
            pull = spring - load - axis.viscous * x[1] - two * axis.slides(x[1])
            motor = (push - one * axis.motor_friction) / axis.motor if one else 0.0
            return [abs(two) * x[1], pull / axis.table if two else 0.0, abs(one) * x[3], motor]

        def left(t, x, one=one):
            stuck = axis.motor_friction - abs(axis.gain * voltage - axis.spring(x))
            return one * x[3] if one else stuck

        def held(t, x, two=two):
            return two * x[1] if two else axis.slides(0.0) - abs(axis.spring(x) - load)

        edges = {flank: -flank} if flank else {1: 1, -1: -1}  # side -> direction
        events = [left, held, *map(axis.edge, edges)]
        for event, falls in zip(events, (-1, -1, *edges.values()), strict=True):
            event.terminal, event.direction = True, falls
        own = {"rtol": 1e-10, "atol": 1e-11, "max_step": 2e-3, "dense_output": True}
        part = solve_ivp(rate, (now, times[-1]), x, "DOP853", events=events, **own)
        inside = (times > now) & (times <= part.t[-1])
        if inside.any():
            found[inside] = part.sol(times[inside]).T
        now, x = part.t[-1], part.y[:, -1].copy()
        for event, place, moves, force in ((0, 3, one, forces[0]), (1, 1, two, forces[1])):
            if len(part.t_events[event]):
                x[place] = 0.0 if moves else nudge * np.sign(force)
        crossed = [side for side, when in zip(edges, part.t_events[2:], strict=True) if len(when)]
        flank = (0 if flank else crossed[0]) if crossed else flank
    return found
