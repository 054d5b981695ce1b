"""Neural network controller that learns in the loop (Huang et al.)."""

from hfc_design.controllers.gains.genome import GainsGenome, GainVectors
from hfc_design.controllers.neural.record import NeuralDesign
from hfc_design.core.numbers import Json


class NeuralGenome(GainsGenome):
    """Genome of the numbers besides the weights; every individual starts with the same weights."""

    def record(self, individual: GainVectors) -> Json:
        """Return a record of the initial weights and of the numbers of a population of one."""
        gains = self.gains(individual)._asdict()
        numbers = {name: float(value[0]) for name, value in gains.items()}
        weights = self.settings.weights().model_dump()
        return {"kind": self.settings.kind, "weights": weights, **numbers}


KIND = NeuralDesign
