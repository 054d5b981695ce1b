"""A neural network that learns in the loop (Huang et al.)."""

from hfc_design.controllers.kind import Kind, later
from hfc_design.controllers.neural.record import NeuralDesign, NeuralSettings

KIND = Kind(
    name="neural",
    summary="a network for all axes that learns off line and on line (Huang et al.)",
    record=NeuralDesign,
    settings=NeuralSettings,
    gains=NeuralDesign.gains,
    controller=NeuralDesign.controller,
    genome=later("hfc_design.controllers.neural.genome", "NeuralGenome"),
    reads=lambda record: ["error"],
    learnt=NeuralDesign.learnt,
    sections=later("hfc_design.controllers.neural.section", "sections"),
)
