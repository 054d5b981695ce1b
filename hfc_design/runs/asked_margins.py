"""Margins that a scenario asks for, of a whole population before anything of it is simulated.

At an operating point the machine with its sensors is the same for all individuals, as a response at
some frequencies: a controller is a small fraction of polynomials beside it. What is between the
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
from hfc_design.stability.margins import ASKED

#: Frequencies, in shares of half the sampling frequency, and how much more is asked.
FREQUENCIES, STRICTER = np.geomspace(1e-3, 1.0, 64), 1.01


class AskedMargins:
    """The loop of a scenario on its nominal machine, and what its margins have to be."""

    def __init__(self, scenario: Scenario, loop: Loop):
        machines, points = one_machine(scenario.plant.values()), operating_points(scenario)
        last = len(points) - 1
        some = [points[k] for k in sorted({0, min(1, last), (last + 1) // 2, last})]
        self._about = near(loop, machines, some)
        self._asked = scenario.margins
        every = self._about.machines
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
        found._about = self._about._replace(loop=self._about.loop._replace(controller=controller))
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
            lambda leaf: np.tile(leaf, (count, *[1] * (leaf.ndim - 1))), self._about.machines
        )
        with np.errstate(all="ignore"):
            own = controlled(self._about.loop, self._about.told, every, machines)
            found = self._margins(own, count)
        known = (own.found & machines.found)[:, None]
        return {name: np.where(known, each, np.nan) for name, each in found.items()}

    def _margins(self, own: Controllers, count: int) -> dict[str, Floats]:
        """(lanes, axes) of each margin."""
        through = _responses(own, self._answers, self._angles, count)
        axes = through.shape[-1]
        whole = np.eye(axes) - through
        if axes == 1:
            sensitivity = 1.0 / whole[..., 0]
        else:
            each = [[j for j in range(axes) if j != k] for k in range(axes)]
            others = [np.linalg.det(whole[..., np.ix_(k, k)[0], np.ix_(k, k)[1]]) for k in each]
            sensitivity = np.stack(others, axis=-1) / np.linalg.det(whole)[..., None]
        loop = (1.0 / sensitivity - 1.0).swapaxes(1, 2)  # (lanes, axes, frequencies)
        size, angle = np.log(np.abs(loop)), self._angles
        # Where it falls to 1 or rises from it, and where it is real and negative.
        share = size[..., :-1] / (size[..., :-1] - size[..., 1:])
        crosses = (size[..., :-1] > 0.0) != (size[..., 1:] > 0.0)
        turned = loop[..., :-1] * (loop[..., 1:] / loop[..., :-1]) ** np.clip(share, 0.0, 1.0)
        ahead = (np.angle(turned) + np.pi) % (2.0 * np.pi)
        at = angle[:-1] * (angle[1:] / angle[:-1]) ** np.clip(share, 0.0, 1.0)
        off = np.minimum(ahead, 2.0 * np.pi - ahead)
        across = loop.imag
        share = across[..., :-1] / (across[..., :-1] - across[..., 1:])
        real = loop.real[..., :-1] + share * np.diff(loop.real)
        gain = np.where((across[..., :-1] > 0.0) != (across[..., 1:] > 0.0), -1.0 / real, np.inf)
        gain = np.concatenate([gain, -1.0 / loop.real[..., -1:]], axis=-1)
        return {
            "sensitivity": _peaks(np.abs(sensitivity)),
            "gain_margin": np.where(gain > 1.0, gain, np.inf).min(axis=-1),
            "phase_margin_deg": np.degrees(np.where(crosses, off, np.inf).min(axis=-1)),
            "delay_margin_samples": np.where(crosses, ahead / at, np.inf).min(axis=-1),
        }


def _peaks(sizes: Floats) -> Floats:
    """(lanes, axes) the tops of (lanes, frequencies, axes), of a parabola through each three."""
    before, here, after = (np.log(sizes[:, k : k - 2 or None]) for k in range(3))
    top, steep, bent = here, 0.5 * (after - before), after + before - 2.0 * here
    top = here - np.where((bent < 0.0) & (np.abs(steep) <= -bent), 0.5 * steep**2 / bent, 0.0)
    return np.maximum(np.exp(top.max(axis=1)), sizes.max(axis=1))


def _responses(own: Controllers, answers: Floats, angles: Floats, count: int) -> Floats:
    """(lanes, frequencies, axes, axes) from commands through the machine to what is commanded.

    ``c adj(z - a) b / det(z - a)`` of the controller by Faddeev and Le Verrier.
    """
    points, size = len(answers), own.a.shape[-1]
    z = np.exp(1j * angles)

    def through(rows: Floats) -> Floats:
        """Rows (lanes, axes, signals) times the answers of the machine."""
        grouped = rows.reshape(count, points, *rows.shape[1:]).swapaxes(0, 1)
        flat = grouped.reshape(points, -1, rows.shape[-1])
        wide = answers.swapaxes(1, 2).reshape(points, rows.shape[-1], -1)
        found = (flat @ wide).reshape(points, count, rows.shape[1], len(z), -1)
        return found.transpose(1, 0, 3, 2, 4).reshape(-1, len(z), rows.shape[1], rows.shape[1])

    straight = through(own.d)
    if not size:
        return straight
    unit, matrix = np.eye(size), np.eye(size) + 0.0 * own.a
    above, below = np.zeros_like(straight), np.ones((len(own.a), len(z)), complex)
    for k in range(1, size + 1):
        above = above * z[:, None, None] + through(own.c @ matrix @ own.b)
        product = own.a @ matrix
        factor = -np.trace(product, axis1=1, axis2=2) / k
        below = below * z + factor[:, None]
        matrix = product + factor[:, None, None] * unit
    return straight + above / below[..., None, None]
