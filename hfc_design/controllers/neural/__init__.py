"""A neural network that learns in the loop (Huang et al.)."""

from hfc_design.controllers.gains.genome import GainsGenome, GainVectors
from hfc_design.controllers.kind import CHANGES, Kind, later
from hfc_design.controllers.neural.law import neural
from hfc_design.controllers.neural.record import NeuralDesign, NeuralSettings
from hfc_design.core.numbers import Json


class NeuralGenome(GainsGenome):
    """What a search can do; every individual begins with the same weights."""

    def record(self, individual: GainVectors) -> Json:
        """The weights and the numbers beside them."""
        found = self.gains(individual)._asdict()
        numbers = {name: float(value[0]) for name, value in found.items()}
        weights = self.settings.weights().model_dump()
        return {"kind": self.settings.kind, "weights": weights, **numbers}


KIND = Kind(
    name="neural",
    summary="a network that learns off line from another controller, then on line (Huang et al.)",
    record=NeuralDesign,
    settings=NeuralSettings,
    gains=NeuralDesign.gains,
    law=lambda record, limit: neural(record.network(), record.sample_time_s, limit),
    genome=NeuralGenome,
    reads=lambda record: ["error"],
    reach=NeuralDesign.reach,
    connecting=lambda record: [CHANGES],
    adapted=NeuralDesign.adapted,
    pictures=later("hfc_design.controllers.neural.section", "pictures"),
    sections=later("hfc_design.controllers.neural.section", "sections"),
)
