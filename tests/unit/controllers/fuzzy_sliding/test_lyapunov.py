"""Lyapunov's function of LG09: it does not grow in the ideal case; what bounds it in any other.

The plant is ``d2e/dt2 = -k_2 de/dt - k_1 e + b (theta*' xi - u)``: what it needs is in the span of
the rules. With ``u = theta' xi + k sat(s / phi)`` and no limits, noise or sampling

    V = E' P E / 2 + b |theta* - theta|^2 / (2 gamma),   dV/dt = -E' Q E / 2 - b (E' P_2) k sat

which is never positive where E' P_2 has the sign of s.
"""

import numpy as np
from scipy.linalg import solve_continuous_lyapunov
from sliding import sliding, table

from hfc_design.controllers.fuzzy_sliding import law as lg
from hfc_design.core.numbers import ARRAYS

SLOPE, GAIN, GAMMA, MOST = 20.0, 500.0, 2.0, 40.0  # lambda, b, gamma, largest move
NEAR, FAR = SLOPE**2, 2.0 * SLOPE  # k_1, k_2: both poles at -lambda
Q = 2.0 * SLOPE * np.diag([SLOPE**2, 1.0])
P = solve_continuous_lyapunov(np.array([[0.0, -NEAR], [1.0, -FAR]]), -Q)


class Loop:
    """Several loops at once, from starts of their own; V of each after every sample."""

    def __init__(self, starts, wanted, limit=np.inf, every=1e-4, gamma=GAMMA):
        adaptation = {"rate": gamma, "largest_move": MOST}
        design = sliding(sample_time_s=every, adaptation=adaptation)
        self.law, self.gains = lg.sliding(every, limit), design.controller.law_gains()
        self.memory = self.law.initial_memory(np.zeros(len(starts)))
        self.error, self.rate = np.array(starts, float).T
        self.wanted, self.gamma, self.limit = wanted, gamma, limit
        self.every, self.table = every, np.array(table())

    def run(self, steps, told=lambda error, rate: (error, rate), pushed=lambda k: 0.0):
        """V (steps, loops); ``told`` is what sensors make of the error, ``pushed`` a load."""
        found = []
        for k in range(steps):
            found.append(self.lyapunov())
            error, rate = told(self.error, self.rate)
            signals = {"error": error, "error_rate": rate}
            command, self.memory, _ = self.law.sample(
                ARRAYS, self.law, self.gains, self.memory, signals
            )
            self.move(np.clip(command, -self.limit, self.limit) + pushed(k))
        return np.array(found)

    def move(self, command):
        """Two steps of the classical Runge-Kutta method under a held command."""
        state, dt = np.array([self.error, self.rate]), self.every / 2.0
        for _ in range(2):
            one = self.slope(state, command)
            two = self.slope(state + 0.5 * dt * one, command)
            three = self.slope(state + 0.5 * dt * two, command)
            four = self.slope(state + dt * three, command)
            state = state + dt / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        self.error, self.rate = state

    def slope(self, state, command):
        error, rate = state
        rows = lg.degrees(ARRAYS, self.gains.error_terms * error)
        columns = lg.degrees(ARRAYS, self.gains.rate_terms * rate)
        needed = np.einsum("in,ij,jn->n", rows, self.wanted, columns)
        return np.array([rate, -FAR * rate - NEAR * error + GAIN * (needed - command)])

    def lyapunov(self):
        state = np.array([self.error, self.rate])
        off = (self.wanted - self.table)[:, :, None] - np.array(self.memory.moves)
        energy = 0.5 * np.einsum("in,ij,jn->n", state, P, state)
        return energy + 0.5 * GAIN / self.gamma * (off**2).sum(axis=(0, 1))


STARTS = [[30.0, 0.0], [-5.0, 800.0], [0.0, 0.0], [50.0, -1500.0]]
#: Consequents that the plant needs: each within the box about those to begin with.
WANTED = np.array(table()) + np.random.default_rng(5).uniform(-30.0, 30.0, (7, 7))


def growth(every, seconds=0.2):
    """The most that V rises in a sample, in shares of it, and V at the end in shares of the first.

    The exact loop has no rise; the sampled one some, of second order in the sample time.
    """
    found = Loop(STARTS, WANTED, every=every).run(round(seconds / every))
    return (np.diff(found, axis=0) / found[:-1]).max(), (found[-1] / found[0]).max()


def test_it_does_not_grow_in_the_ideal_case():
    coarse, _ = growth(2e-3)
    fine, left = growth(5e-4)
    assert fine < 3e-6
    assert fine < coarse / 12.0  # of second order: it would be a sixteenth
    assert left < 1.0


def test_what_learns_has_no_error_left():
    """Without adaptation V has no reason to fall: a steady error is left."""
    still, learning = (Loop(STARTS, WANTED, every=2e-3, gamma=g) for g in (1e-9, GAMMA))
    for loop in (still, learning):
        loop.run(400)
    assert (np.abs(still.error) > 3.0).all()
    assert (np.abs(learning.error) < 0.05).all()


#: Noise of the error, its quantum, the amplitude of a load, the limit of the command; what error
#: is left at most. The noise of the rate is that of a difference over 10 ms.
DISTURBED = {
    "a quantum of 1": ([0.0, 1.0, 0.0, np.inf], 0.6),
    "a limit of 60": ([0.0, 1e-9, 0.0, 60.0], 0.1),
    "a load of 15": ([0.0, 1e-9, 15.0, np.inf], 8.0),
    "noise of 1": ([1.0, 1e-9, 0.0, np.inf], 3.0),
    "all of it": ([1.0, 1.0, 15.0, 60.0], 9.0),
}


def test_beyond_the_ideal_case_it_is_bounded():
    """By its box: no consequent is farther off than it, so that V is finite and the error is too.

    The error dynamics make of a command that is off by w an error of ``b |w| / lambda^2`` at most.
    """
    noise, quantum, load, limit = np.array([values for values, _ in DISTURBED.values()]).T
    random = np.random.default_rng(6)

    def told(error, rate):
        off, rate_off = noise * random.standard_normal((2, len(noise)))
        return quantum * np.round((error + off) / quantum), rate + 140.0 * rate_off

    loop = Loop([[30.0, 0.0]] * len(noise), WANTED, limit, every=2e-3)
    late, energy = np.zeros(len(noise)), []
    for part in range(350):
        step = loop.run(2, told, lambda k, part=part: load * np.sign(np.sin(part / 75.0)))
        energy.append(step[-1])
        late = np.maximum(late, np.abs(loop.error) * (part > 200))
    moves = np.abs(loop.memory.moves).max(axis=(0, 1))
    assert moves.max() == MOST  # noise pushes some to the edge of their box, and none beyond
    assert dict(zip(DISTURBED, moves == MOST, strict=True)) == {
        name: "noise" in name or "all" in name for name in DISTURBED
    }
    off = MOST + 30.0 + 10.0 + load  # of consequents and the switching part, in the worst case
    steady = GAIN * off / SLOPE**2
    assert (late < steady).all()
    for (name, (_, most)), found in zip(DISTURBED.items(), late, strict=True):
        assert found < most, (name, late)
    growth = np.max(energy, axis=0) / energy[0]
    assert (growth < 1.05).all()
