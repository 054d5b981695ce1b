"""Genome of ``lqr`` and ``lqi``: weights, so that every individual is an optimal regulator."""

from typing import Any

import numpy as np

from hfc_design.controllers.gains.genome import GainVectors, Searched
from hfc_design.controllers.linear import regulator
from hfc_design.controllers.linear.genome import LinearGenome
from hfc_design.controllers.linear.law import ERRORS
from hfc_design.core.numbers import Floats, Json

#: Factor between the weights of a good individual and the ends of their ranges.
WIDER = 100.0
#: Weight of a signal in a good individual, in shares of the gain that it gets without a weight.
LIGHT = 0.03
#: Weight of a resonator as a share of another weight (see ``weights``): lowest, highest, start.
RESONANT = (1e-3, 1e4, 1.0)


class LqGenome(LinearGenome):
    """Genome of weights [command/state]; the weight of the command is 1."""

    def _prepare(self) -> None:
        signals = self.settings.signals
        self.states = plain = regulator.measured(self.model, signals, self.drive.name)
        if self.settings.kind == "lqi":
            self.states = plain.with_integral(self.every)
        #: States with a weight of their own; that of a resonator is a share of another weight.
        self.weighted = self.states.names
        angles = [x * self.every for x in self.settings.load_frequencies_rad_s]
        self.states = self.states.with_resonators(angles, self.every)
        self.plain = plain
        limit = next(iter(self.target.limits.values()))
        largest = self.drive.largest_commands(self.target.parameters[0], limit)[1]
        self.tolerated = {name: largest / x for name, x in self.settings.tolerances.items()}

    @property
    def signals(self) -> tuple[str, ...]:
        """Names of the signals that are fed back: of all states of ``plain`` except ``ERRORS``."""
        return tuple(name for name in self.plain.names if name not in ERRORS)

    def designed(self, bandwidths: Floats) -> dict[str, Floats]:
        """Return as weights the gains of a PID on error and integral, and small ones on the rest.

        A state with a tolerance gets the weight of Bryson's rule instead: a value as large as the
        tolerance costs as much as the largest command.
        """
        kp, ki, kd = regulator.pid(self.model, bandwidths)
        gains = regulator.first_regulators(self.plain, kp, kd)
        weights = {"integral": ki, "error": kp, "error_rate": LIGHT * kd}
        weights |= {name: LIGHT * abs(gains[name]) for name in self.signals}
        for name, weight in self.tolerated.items():
            weights[name] = np.full_like(kp, weight)
        return {name: weights[name] for name in self.weighted}

    def _searched(
        self, low: dict[str, float], high: dict[str, float], start: dict[str, float]
    ) -> dict[str, Searched]:
        kp, ki, kd = regulator.pid(self.model, np.array(self.bandwidths[:1]))
        gains: dict[str, Any] = dict.fromkeys(self.states.names, ki)  # for the integral too
        gains |= regulator.first_regulators(self.plain, kp, kd)
        self.scale = np.array([abs(gains[name][0]) for name in self.states.names])
        each = zip(start, low.values(), high.values(), start.values(), strict=True)
        searched = {
            name: Searched(min(ends) / WIDER, max(ends) * WIDER, begin)
            for name, *ends, begin in each
        }
        return searched | dict.fromkeys(self.settings.resonators, Searched(*RESONANT))

    def weights(self, values: dict[str, Floats]) -> dict[str, Floats]:
        """Return the weight of every state that has one.

        The weight of a resonator is on its first state. It is searched as a share of the weight of
        the integral, or, without an integral, of the weight of the error times the frequency. Good
        loops have similar shares on all resonators.
        """
        weights = {name: values[name] for name in self.weighted}
        each = zip(self.settings.resonators, self.settings.load_frequencies_rad_s, strict=True)
        for name, frequency in each:
            whole = values.get("integral", values["error"] * frequency)
            weights[name] = values[name] * whole
        return weights

    def _feedback(self, values: dict[str, Floats]) -> dict[str, Floats]:
        named_weights, nothing = self.weights(values), np.zeros_like(values["error"])
        weights = np.stack([named_weights.get(name, nothing) for name in self.states.names], axis=1)
        regulator_gains = regulator.regulators(self.states, weights, self.scale)
        gains = dict(zip(self.states.names, regulator_gains.T, strict=True))
        named = {"kp": gains.pop("error"), "kd": gains.pop("error_rate"), "filter_pole": 0.0}
        return {**named, "ki": gains.pop("integral", 0.0), **gains}

    def record(self, individual: GainVectors) -> Json:
        """Return the record with gains and weights."""
        weight_arrays = self.weights(self.values(individual))
        weights = {name: float(weight[0]) for name, weight in weight_arrays.items()}
        return super().record(individual) | {"weights": weights}
