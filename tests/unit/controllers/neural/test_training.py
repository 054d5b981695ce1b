"""A network off line and on line: taught, simulated, searched, refused, and one that diverges."""

import numpy as np
import pytest
from wording import refused

import hfc_design.api as hfc
from hfc_design.controllers.neural.record import NeuralDesign, drawn
from hfc_design.controllers.neural.training import command, inputs_of, trained
from hfc_design.core.records import checked


def network(**changes):
    numbers = {"error_unit": 1.0, "change_unit": 1.0, "command_unit": 1.0, "slope": 0.1}
    own = {"sample_time_s": 0.01, "weights": drawn(25, 0)} | numbers | changes
    return NeuralDesign(**own)


def test_it_learns_a_law_of_the_error_and_its_change():
    """That of a PD, over errors that wander, from two axes at once."""
    random = np.random.default_rng(1)
    errors = random.uniform(-2.0, 2.0, (4000, 2))
    change = np.diff(errors, axis=0, prepend=0.0)
    wanted = 3.0 * errors - 0.8 * change
    found = trained(network(), errors, wanted, hfc.Lesson(rate=0.2))
    assert found.taught == pytest.approx(np.sqrt(np.mean(wanted**2)))
    assert found.before > 0.9 * found.taught
    assert found.after < 0.02 * found.taught
    tried = np.array([[1.0, 0.5], [-0.5, 1.0]])
    assert command(found.design, tried) == pytest.approx([2.6, -2.3], abs=0.1)
    assert inputs_of(found.design, np.array([1.0, 3.0])).tolist() == [[1.0, 1.0], [3.0, 2.0]]


def test_weights_of_another_size_are_one_line(tmp_path):
    data = network().model_dump(mode="json")
    data["weights"]["output"] = data["weights"]["output"][:-1]
    with refused() as found:
        checked(NeuralDesign, data, "mine.json", tmp_path)
    assert "mine.json: weights.output" in found.refusal
    data["weights"]["hidden"][3] = [1.0, 2.0]
    with refused() as found:
        checked(NeuralDesign, data, "mine.json", tmp_path)
    assert "mine.json: weights.hidden.3" in found.refusal
