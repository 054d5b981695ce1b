"""A neural network that learns in the loop (Huang et al.)."""

from pathlib import Path

from hfc_design.controllers.kind import CHANGES, Kind, Template, later
from hfc_design.controllers.neural.law import neural
from hfc_design.controllers.neural.record import NeuralDesign, NeuralSettings
from hfc_design.controllers.neural.saved import SAVED
from hfc_design.core.numbers import Json


def _c(record: NeuralDesign) -> Json:
    units = len(record.weights.hidden)
    numbers = {"gains": record.gains(), "weights": record.weights, "units": units}
    return {**numbers, "hyperbolic": True, "integrates": True}


KIND = Kind(
    name="neural",
    summary="a network that learns off line from another controller, then on line (Huang et al.)",
    record=NeuralDesign,
    settings=NeuralSettings,
    gains=NeuralDesign.gains,
    law=lambda record, limit: neural(record.network(), record.sample_time_s, limit),
    genome=later("hfc_design.controllers.neural.genome", "NeuralGenome"),
    reads=lambda record: ["error"],
    reach=NeuralDesign.reach,
    connecting=lambda record: [CHANGES],
    adapted=NeuralDesign.adapted,
    saved=SAVED,
    c=Template((Path(__file__).parent / "templates",), _c),
    pictures=later("hfc_design.controllers.neural.section", "pictures"),
    sections=later("hfc_design.controllers.neural.section", "sections"),
)
