"""Resonators: by SciPy's filter, on a linear plant by its transfer function, at a limit."""

import json

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from hfc_design import api
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, design_json
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller

EVERY = 0.01
MASS, FRICTION = 2.0, 3.0


def design(limit=None, **own):
    data = {
        "name": "mine",
        "plant": {"name": "c-axis", "parameters": {}},
        "controller": {"kind": "pid+ff", "sample_time_s": EVERY, "kp": 0.0} | own,
        "limits": {"command": limit} if limit else {},
    }
    return Design.model_validate(data)


def one(frequency, in_phase, quadrature):
    return {"frequency_rad_s": frequency, "in_phase": in_phase, "quadrature": quadrature}


def told(error):
    return {"error": error, "error_rate": 0.0, "reference_rate": 0.0, "reference_acceleration": 0.0}


def plant():
    """(a, b) of place and speed, held for a sample."""
    rates = np.array([[0.0, 1.0], [0.0, -FRICTION / MASS]])
    a, b, *_ = cont2discrete((rates, np.array([[0.0], [1.0 / MASS]]), np.eye(2), 0), EVERY)
    return a, b[:, 0]


def filters(in_phase, quadrature, angle):
    """Numerator and denominator in z^-1: T (p (z - cos) - q sin) / (z^2 - 2 cos z + 1)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    above = EVERY * np.array([0.0, in_phase, -in_phase * cosine - quadrature * sine])
    return above, np.array([1.0, -2.0 * cosine, 1.0])


def test_it_is_the_filter_of_scipy():
    """A random error through two of them, whose outputs add up."""
    errors = np.random.default_rng(1).normal(size=400)
    pairs = {7.0: (3.0, -40.0), 250.0: (-60.0, 20.0)}
    controller = Controller(design(resonators=[one(x, *pair) for x, pair in pairs.items()]))
    found = [controller.step(told(error)) for error in errors.tolist()]
    each = [lfilter(*filters(*pair, x * EVERY), errors) for x, pair in pairs.items()]
    np.testing.assert_allclose(found, sum(each), atol=1e-12 * np.abs(found).max())


def test_with_an_error_of_its_frequency_it_grows_in_phase_and_a_quarter_turn_ahead():
    """Of cos it makes t/2 (p cos - q sin), as the continuous one does, here 2,000 turns of T w."""
    frequency, pair = 9.0, (5.0, 2.0)
    controller = Controller(design(resonators=[one(frequency, *pair)]))
    times = EVERY * np.arange(2001)
    found = [controller.step(told(x)) for x in np.cos(frequency * times).tolist()]
    late = frequency * EVERY  # what is summed up acts a sample later
    turned = frequency * times - late
    expected = 0.5 * times * (pair[0] * np.cos(turned) - pair[1] * np.sin(turned))
    np.testing.assert_allclose(found, expected, atol=0.01 * np.abs(found).max())


def test_at_its_limit_a_resonator_turns_on_but_is_not_driven_further():
    """1 V: the kp of 10 V alone is beyond. Its size stays, its angle goes on; then it is driven."""
    controller = Controller(design(limit=1.0, kp=10.0, resonators=[one(5.0, 4.0, -3.0)]))

    def after(error):
        controller.step(told(error))
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
    other.step(told(3.0))
    assert complex(*other._memory.resonators[0]) == pytest.approx(EVERY * 3.0 * (4.0 + 3.0j))


@pytest.mark.parametrize(
    ("frequencies", "fault"),
    [
        ([50.0, 1.0], r"load_frequencies_rad_s = .*: have to rise, each by 0.1 % at least"),
        ([50.0, 50.01], r"have to rise"),
        ([0.0], r"load_frequencies_rad_s.0 = 0.0: has to be greater than 0"),
        ([3142.0], r"load_frequencies_rad_s: 3142 rad/s has to be below 3141.59, half the samp"),
        ([float(x) for x in range(1, 10)], r"at most 8 entries"),
    ],
)
@pytest.mark.parametrize("key", ["controller", "controller.linear"])
def test_frequencies_that_cannot_be_told_are_refused_in_a_line(frequencies, fault, key):
    own = {"load_frequencies_rad_s": frequencies}
    own = {"controller": {"kind": "lqi", **own}} if key == "controller" else {key: own}
    with pytest.raises(UserError, match=fault) as refused:
        genome_of(api.load_scenario("c-axis-ramp", own))
    assert key in str(refused.value)


@pytest.mark.parametrize(
    ("resonators", "fault"),
    [
        ([one(50.0, 1.0, 1.0), one(1.0, 1.0, 1.0)], "have to rise"),
        ([one(400.0, 1.0, 1.0)], "resonators: 400 rad/s has to be below 314.159, half the samp"),
        ([one(1.0, "x", 1.0)], "resonators.0.in_phase = 'x'"),
        (
            [{"frequency_rad_s": 1.0}],
            "resonators.0.in_phase, controller.resonators.0.quadrature: are missing",
        ),
    ],
)
def test_a_design_that_cannot_run_is_refused(resonators, fault, tmp_path):
    data = json.loads(design_json(design()))
    data["controller"]["resonators"] = resonators
    (tmp_path / "mine.json").write_text(json.dumps(data))
    with pytest.raises(UserError, match=fault):
        api.load_design(tmp_path / "mine.json")
