"""Margins that a scenario asks for, of a whole population before anything of it is simulated.

At an operating point the machine with its sensors is the same for all individuals, as a response at
some frequencies, and a controller is small beside it. What is between the
frequencies is interpolated, so that a little more is asked than the scenario does; the answer of
``usable`` is exact.
"""

from copy import copy

import jax
import numpy as np

from hfc_design.controllers.controller import Controller
from hfc_design.core.numbers import Floats, Gains
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.closed_loop import Loop
from hfc_design.simulation.linearised import Controllers, Steady, controlled
from hfc_design.simulation.loop_margins import near, operating_points
from hfc_design.simulation.population import one_machine
from hfc_design.stability.margins import ASKED, crossings

#: Frequencies, in shares of half the sampling frequency, and how much more is asked.
FREQUENCIES, STRICTER = np.geomspace(1e-3, 1.0, 64), 1.01


class AskedMargins:
    """The loop of a scenario on its nominal machine, and what its margins have to be."""

    def __init__(self, scenario: Scenario, loop: Loop):
        machines, points = one_machine(scenario.plant.values()), operating_points(scenario)
        last = len(points) - 1
        some = [points[k] for k in sorted({0, min(1, last), (last + 1) // 2, last})]
        self._machines = every = near(loop, machines, some)
        self._loop, self._told, self._asked = loop, machines.told, scenario.margins
        poles = np.linalg.eigvals(every.a).ravel()
        light = poles[(poles.imag > 0.0) & (np.abs(poles) > 0.9)]
        self._angles = np.unique(np.append(np.pi * FREQUENCIES, np.angle(light)))
        z = np.exp(1j * self._angles)[:, None, None]
        unit = np.eye(every.a.shape[-1])
        #: (points, frequencies, signals, axes) signals that commands bring about.
        self._answers = every.c[:, None] @ np.linalg.solve(
            z * unit - every.a[:, None], every.b[:, None].astype(complex)
        )

    def of(self, controller: Controller) -> "AskedMargins":
        """The same with another controller."""
        found = copy(self)
        found._loop = self._loop._replace(controller=controller)
        return found

    def broken(self, gains: Gains) -> Floats:
        """(individuals,) by how much each breaks what is asked, 0 for nothing."""
        found = self.margins(gains)
        total = np.zeros(jax.tree.leaves(gains)[0].shape[-1])
        for name, limit in self._asked.items():
            value, more = found[name], ASKED[name][1]
            with np.errstate(divide="ignore"):
                over = value / limit * STRICTER if more else limit * STRICTER / value
            worst = np.nan_to_num(over - 1.0, nan=0.0, posinf=np.inf).max(axis=1, initial=0.0)
            total += 1.0 - 1.0 / (1.0 + worst.reshape(len(total), -1).max(axis=1))
        return total

    def margins(self, gains: Gains) -> dict[str, Floats]:
        """(individuals x points, axes) of each margin; nan of a loop that cannot be linearised."""
        points, count = len(self._answers), jax.tree.leaves(gains)[0].shape[-1]
        every = jax.tree.map(lambda leaf: np.repeat(leaf, points, axis=-1), gains)
        machines: Steady = jax.tree.map(
            lambda leaf: np.tile(leaf, (count, *[1] * (leaf.ndim - 1))), self._machines
        )
        with np.errstate(all="ignore"):
            own = controlled(self._loop, self._told, every, machines)
            found = self._margins(own, count)
        known = (own.found & machines.found)[:, None]
        return {name: np.where(known, each, np.nan) for name, each in found.items()}

    def _margins(self, own: Controllers, count: int) -> dict[str, Floats]:
        """(lanes, axes) of each margin."""
        through = _responses(own, self._answers, self._angles, count)
        whole = np.eye(through.shape[-1]) - through
        others = [np.delete(np.delete(whole, k, -1), k, -2) for k in range(whole.shape[-1])]
        sensitivity = np.stack([np.linalg.det(each) for each in others], axis=-1)
        sensitivity = sensitivity / np.linalg.det(whole)[..., None]
        loop = (1.0 / sensitivity - 1.0).swapaxes(1, 2)  # (lanes, axes, frequencies)
        gain, unity, lags = crossings(self._angles, loop)
        found = {
            "gain_margin": np.where(gain > 1.0, gain, np.inf),
            "phase_margin_deg": np.degrees(np.minimum(lags, 2.0 * np.pi - lags)),
            "delay_margin_samples": lags / unity,
        }
        least = {name: np.fmin.reduce(each, -1, initial=np.inf) for name, each in found.items()}
        return {"sensitivity": _peaks(np.abs(sensitivity)), **least}


def _peaks(sizes: Floats) -> Floats:
    """(lanes, axes) the tops of (lanes, frequencies, axes), of a parabola through each three."""
    before, here, after = (np.log(sizes[:, k : k - 2 or None]) for k in range(3))
    top, steep, bent = here, 0.5 * (after - before), after + before - 2.0 * here
    top = here - np.where((bent < 0.0) & (np.abs(steep) <= -bent), 0.5 * steep**2 / bent, 0.0)
    return np.maximum(np.exp(top.max(axis=1)), sizes.max(axis=1))


def _responses(own: Controllers, answers: Floats, angles: Floats, count: int) -> Floats:
    """(lanes, frequencies, axes, axes) from commands through the machine to what is commanded."""
    z, unit = np.exp(1j * angles)[:, None, None], np.eye(own.a.shape[-1])
    told = own.c.swapaxes(1, 2)[:, None].astype(complex)
    inner = np.linalg.solve(z * unit - own.a.swapaxes(1, 2)[:, None], told).swapaxes(2, 3)
    rows = own.d[:, None] + inner @ own.b[:, None]
    return (rows.reshape(count, -1, *rows.shape[1:]) @ answers).reshape(*rows.shape[:3], -1)
