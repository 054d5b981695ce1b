"""A neural network that learns in the loop (Huang et al.)."""

from pathlib import Path

from hfc_design.controllers.gains.genome import GainsGenome, GainVectors
from hfc_design.controllers.kind import CHANGES, STARTED, Kind, Member, Saved, Template, later
from hfc_design.controllers.neural.law import Weights, neural
from hfc_design.controllers.neural.record import INPUTS, NeuralDesign, NeuralSettings
from hfc_design.core.numbers import Floats, Json


def _c(record: NeuralDesign) -> Json:
    units = len(record.weights.hidden)
    numbers = {"gains": record.gains(), "weights": record.weights, "units": units}
    return {**numbers, "hyperbolic": True, "integrates": True}


def _learnt(record: NeuralDesign) -> list[Member]:
    """Its weights by now, as far as it learns."""
    if not record.rate:
        return []
    units = len(record.weights.hidden)
    return [
        Member("hidden", (units, INPUTS + 1), "[unit][error, its change, threshold]"),
        Member("output", (units + 1,), "of the hidden units, last the threshold"),
    ]


def _past(record: NeuralDesign) -> list[Member]:
    moved = [Member(f"{one.name}_moved", one.shape) for one in _learnt(record)]
    return [STARTED, Member("error", what="of the sample before"), *moved]


def _taken(record: NeuralDesign, found: dict[str, Floats]) -> NeuralDesign:
    layers = found["hidden"].tolist(), [found["output"].tolist()]
    return record.with_weights(Weights(*layers))


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
    saved=Saved(_learnt, _past, _taken),
    c=Template((Path(__file__).parent / "templates",), _c),
    pictures=later("hfc_design.controllers.neural.section", "pictures"),
    sections=later("hfc_design.controllers.neural.section", "sections"),
)
