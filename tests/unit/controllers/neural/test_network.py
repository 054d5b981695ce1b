"""Back-propagation against derivatives that JAX finds, momentum and the law by hand."""

from math import tanh

import numpy as np
import pytest
from wording import refused

import hfc_design.api as hfc
from hfc_design.controllers.neural.law import NeuralGains, Weights, neural
from hfc_design.controllers.neural.record import NeuralDesign, command, drawn, inputs_of, trained
from hfc_design.core.numbers import SCALARS
from hfc_design.core.records import checked


def test_two_samples_of_the_law_by_hand():
    """One hidden unit, errors counted in 2, changes in 4, commands in 10; limited to 12."""
    gains = NeuralGains(2.0, 4.0, 10.0, rate=0.1, momentum=0.5, slope=0.5, xi=0.25)
    law = neural(Weights([[1.0, -2.0, 0.5]], [[3.0, -1.0]]), 0.005, 12.0)
    memory = law.initial_memory(0.0)
    first, memory = law.step(SCALARS, gains, memory, {"error": 1.0})
    h = tanh(0.5 * (0.5 * 1.0 - 2.0 * 0.25 + 0.5))  # e = 0.5, ce = 0.25
    assert first == pytest.approx(10.0 * (3.0 * h - 1.0), rel=1e-14)
    delta = 0.1 * (0.75 * 0.5 + 0.25 * 0.25)
    back = delta * 3.0 * 0.5 * (1.0 - h * h)
    hidden = [1.0 + back * 0.5, -2.0 + back * 0.25, 0.5 + back]
    output = [3.0 + delta * h, -1.0 + delta]
    assert memory.weights.hidden == [pytest.approx(hidden, rel=1e-14)]
    assert memory.weights.output == [pytest.approx(output, rel=1e-14)]
    # The second: the command would be beyond 12, and an error above 0 teaches nothing more.
    second, after = law.step(SCALARS, gains, memory, {"error": 40.0})
    assert second == 12.0
    assert after.weights.output[0] == pytest.approx(
        [w + 0.5 * (w - v) for w, v in zip(output, [3.0, -1.0], strict=True)], rel=1e-14
    )


def design(**changes):
    numbers = {"error_unit": 1.0, "change_unit": 1.0, "command_unit": 1.0, "slope": 0.1}
    own = {"sample_time_s": 0.01, "weights": drawn(25, 0)} | numbers | changes
    return NeuralDesign(**own)


def test_it_learns_a_law_of_the_error_and_its_change():
    """That of a PD, over errors that wander, from two axes at once."""
    random = np.random.default_rng(1)
    errors = random.uniform(-2.0, 2.0, (2000, 2))
    change = np.diff(errors, axis=0, prepend=0.0)
    wanted = 3.0 * errors - 0.8 * change
    found = trained(design(), errors, wanted, hfc.Lesson(rate=0.2))
    assert found.taught == pytest.approx(np.sqrt(np.mean(wanted**2)))
    assert found.before > 0.9 * found.taught
    assert found.after < 0.02 * found.taught
    tried = np.array([[1.0, 0.5], [-0.5, 1.0]])
    assert command(found.design, tried) == pytest.approx([2.6, -2.3], abs=0.1)
    assert inputs_of(found.design, np.array([1.0, 3.0])).tolist() == [[1.0, 1.0], [3.0, 2.0]]


def test_weights_of_another_size_are_one_line(tmp_path):
    data = design().model_dump(mode="json")
    data["weights"]["output"] = data["weights"]["output"][:-1]
    with refused() as found:
        checked(NeuralDesign, data, "mine.json", tmp_path)
    assert "mine.json: weights.output" in found.refusal
    data["weights"]["hidden"][3] = [1.0, 2.0]
    with refused() as found:
        checked(NeuralDesign, data, "mine.json", tmp_path)
    assert "mine.json: weights.hidden.3" in found.refusal


def test_first_weights_are_uniform_and_the_seed_s():
    found = [drawn(100, seed) for seed in (0, 0, 1)]
    assert found[0] == found[1] != found[2]
    values = np.concatenate([np.ravel(found[0].hidden), found[0].output])
    assert values.size == 401
    assert abs(values).max() <= 1.0
    assert abs(values.mean()) < 0.1
    assert values.std() == pytest.approx(1.0 / np.sqrt(3.0), rel=0.05)
