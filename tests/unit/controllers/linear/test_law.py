"""The linear law: by hand, and against SciPy's simulation of a friction-free drive."""

import json
import math

import numpy as np
import pytest
from linear_designs import STILL, design
from scipy.signal import lfilter
from wording import refused

from hfc_design import api
from hfc_design.files.design import parse_design
from hfc_design.runtime import Controller


def commands(controller, *samples):
    return [controller.step(STILL | own) for own in samples]


def test_three_samples_by_hand():
    """kp e + integral of the samples before + kd rate + gain x deflection."""
    controller = Controller(design(kp=2.0, ki=50.0, kd=0.1, signals={"deflection": -30.0}))
    found = commands(
        controller,
        {"error": 1.0, "error_rate": 4.0, "deflection": 0.2},
        {"error": 3.0, "error_rate": -2.0, "deflection": 0.0},
        {"error": -1.0, "deflection": 0.1},
    )
    # after the first sample the integral is 50 x 0.01 x 1, then 50 x 0.01 x (1 + 3)
    assert found == pytest.approx([2.0 + 0.4 - 6.0, 6.0 - 0.2 + 0.5, -2.0 + 2.0 - 3.0])


def test_feed_forward_by_hand():
    ahead = {"velocity": 10.0, "acceleration": 2.0, "coulomb": 5.0, "coulomb_width": 0.02}
    controller = Controller(design(feed_forward={**ahead, "load": 3.0, "expected_load": -4.0}))
    rates = [{"reference_rate": v, "reference_acceleration": 1.5} for v in (0.5, 0.01, 0.0, -0.3)]
    # acceleration 3, load -12; the Coulomb part is whole from 0.02 on
    expected = [5.0 + 5.0 - 9.0, 0.1 + 2.5 - 9.0, -9.0, -3.0 - 5.0 - 9.0]
    assert commands(controller, *rates) == pytest.approx(expected)


def test_the_integral_stays_where_the_command_is_at_its_limit():
    """At 10 V more of the same error does not count, an opposite one does at once."""
    controller = Controller(design(limit=10.0, kp=1.0, ki=100.0))
    assert commands(controller, *[{"error": 4.0}] * 3) == pytest.approx([4.0, 8.0, 10.0])
    assert controller._memory.integral == pytest.approx(8.0)  # 4 + 8 = 12 is beyond: held
    assert commands(controller, {"error": -1.0}, {"error": 0.0}) == pytest.approx([7.0, 7.0])


def test_the_filter_is_that_of_scipy():
    """A lag of 7 Hz before kd, of the same steps: y(k) = a y(k-1) + (1 - a) x(k)."""
    controller = Controller(design(kd=3.0, derivative_hz=7.0))
    rates = np.random.default_rng(1).normal(size=50)
    kept = math.exp(-2.0 * math.pi * 7.0 * 0.01)
    expected = 3.0 * lfilter([1.0 - kept], [1.0, -kept], rates)
    found = commands(controller, *({"error_rate": x} for x in rates))
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("cut_off", [None, 0.0])
def test_without_a_filter_it_is_the_pd_controller(cut_off):
    mine = Controller(design(kp=700.0, kd=30.0, derivative_hz=cut_off, every=0.001))
    pd = api.load_design("pd-only", {"controller.pd.kp": 700.0, "controller.pd.kd": 30.0})
    other = Controller(pd)
    for error, rate in np.random.default_rng(2).normal(size=(20, 2)).tolist():
        sample = {"error": error, "error_rate": rate}
        assert mine.step(STILL | sample) == other.step(sample)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("signals", {"error": 1.0}),
        ("signals", {"reference_rate": 1.0}),
        ("feed_forward", {"coulomb": 1.0}),
        ("derivative_hz", -1.0),
        ("weights", {"error": 1.0}),
    ],
)
def test_a_design_that_cannot_run_is_refused(key, value):
    data = design().model_dump(mode="json")
    data["controller"][key] = value
    with refused() as found:
        parse_design(json.dumps(data), "mine.json")
    assert f"mine.json: controller.{key}" in found.refusal
