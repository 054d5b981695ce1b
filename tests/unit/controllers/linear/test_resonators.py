"""Resonators: by SciPy's filter, on a linear plant by its transfer function, at a limit."""

import json

import numpy as np
import pytest
from linear_designs import EVERY, STILL, design, filters, one
from scipy.signal import lfilter
from wording import refused

from hfc_design import api
from hfc_design.files.design import design_json, parse_design
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller


def test_it_is_the_filter_of_scipy():
    """A random error through two of them, whose outputs add up."""
    errors = np.random.default_rng(1).normal(size=400)
    pairs = {7.0: (3.0, -40.0), 250.0: (-60.0, 20.0)}
    controller = Controller(design(resonators=[one(x, *pair) for x, pair in pairs.items()]))
    found = [controller.step(STILL | {"error": error}) for error in errors.tolist()]
    each = [lfilter(*filters(*pair, x * EVERY), errors) for x, pair in pairs.items()]
    np.testing.assert_allclose(found, sum(each), atol=1e-12 * np.abs(found).max())


def test_with_an_error_of_its_frequency_it_grows_in_phase_and_a_quarter_turn_ahead():
    """Of cos it makes t/2 (p cos - q sin), as the continuous one does, here 2,000 turns of T w."""
    frequency, pair = 9.0, (5.0, 2.0)
    controller = Controller(design(resonators=[one(frequency, *pair)]))
    times = EVERY * np.arange(2001)
    found = [controller.step(STILL | {"error": x}) for x in np.cos(frequency * times).tolist()]
    late = frequency * EVERY  # what is summed up acts a sample later
    turned = frequency * times - late
    expected = 0.5 * times * (pair[0] * np.cos(turned) - pair[1] * np.sin(turned))
    np.testing.assert_allclose(found, expected, atol=0.01 * np.abs(found).max())


def test_at_its_limit_a_resonator_turns_on_but_is_not_driven_further():
    """1 V: the kp of 10 V alone is beyond. Its size stays, its angle goes on; then it is driven."""
    controller = Controller(design(limit=1.0, kp=10.0, resonators=[one(5.0, 4.0, -3.0)]))

    def after(error):
        controller.step(STILL | {"error": error})
        ((share, behind),) = controller._memory.resonators
        return complex(share, behind)

    first = after(0.05)  # 0.5 V: driven
    assert first == pytest.approx(EVERY * 0.05 * (4.0 + 3.0j))
    turn = np.exp(-5j * EVERY)
    held = [after(3.0) for _ in range(50)]
    np.testing.assert_allclose(held, first * turn ** np.arange(1, 51), rtol=1e-12)
    # Beyond it the other way: -30 V would be pushed down, an error of +3 with -40 V of signals up.
    assert after(-3.0) == pytest.approx(held[-1] * turn)
    other = Controller(design(limit=1.0, kp=-10.0, resonators=[one(5.0, 4.0, -3.0)]))
    other.step(STILL | {"error": 3.0})
    assert complex(*other._memory.resonators[0]) == pytest.approx(EVERY * 3.0 * (4.0 + 3.0j))


@pytest.mark.parametrize(
    "frequencies",
    [[50.0, 1.0], [50.0, 50.01], [0.0], [3142.0], [float(x) for x in range(1, 10)]],
)
@pytest.mark.parametrize("key", ["controller", "controller.linear"])
def test_frequencies_that_cannot_be_told_are_refused_in_a_line(frequencies, key):
    own = {"load_frequencies_rad_s": frequencies}
    own = {"controller": {"kind": "lqi", **own}} if key == "controller" else {key: own}
    with refused() as found:
        genome_of(api.load_scenario("c-axis-ramp", own))
    assert f"{key}.load_frequencies_rad_s" in found.refusal


@pytest.mark.parametrize(
    "resonators",
    [
        [one(50.0, 1.0, 1.0), one(1.0, 1.0, 1.0)],
        [one(400.0, 1.0, 1.0)],
        [one(1.0, "x", 1.0)],
        [{"frequency_rad_s": 1.0}],
    ],
)
def test_a_design_that_cannot_run_is_refused(resonators):
    data = json.loads(design_json(design()))
    data["controller"]["resonators"] = resonators
    with refused() as found:
        parse_design(json.dumps(data), "mine.json")
    assert "mine.json: controller.resonators" in found.refusal
