"""What of a network is saved: its weights by now."""

from hfc_design.controllers.kind import STARTED, Member, Saved
from hfc_design.controllers.neural.network import Weights
from hfc_design.controllers.neural.record import INPUTS, NeuralDesign
from hfc_design.core.numbers import Floats


def _learnt(record: NeuralDesign) -> list[Member]:
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


SAVED = Saved(_learnt, _past, _taken)
