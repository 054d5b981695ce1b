"""The linear law: by hand, and against SciPy's simulation of a friction-free drive."""

import json
import math
from math import nan

import numpy as np
import pytest
from linear_designs import EVERY, STILL, design, filters, one
from scipy.linalg import solve_discrete_are
from scipy.signal import butter, freqz, iirnotch, lfilter
from wording import refused

from hfc_design import api
from hfc_design.controllers.linear.regulator import measured, regulators
from hfc_design.files.design import parse_design
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller
from hfc_design.stability.nominal import Nominal, Steady


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


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("signals", {"error": 1.0}),
        ("feed_forward", {"coulomb": 1.0}),
        ("derivative_hz", -1.0),
        ("notch_hz", 50.0),
        ("lowpass_hz", 60.0),
        ("notch_depth", 1.5),
        ("resonators", [one(50.0, 1.0, 1.0), one(1.0, 1.0, 1.0)]),
        ("resonators", [one(400.0, 1.0, 1.0)]),
    ],
)
def test_a_design_that_cannot_run_is_refused(key, value):
    data = design().model_dump(mode="json")
    data["controller"][key] = value
    with refused() as found:
        parse_design(json.dumps(data), "mine.json")
    assert f"mine.json: controller.{key}" in found.refusal


def test_filters_of_the_command_are_those_of_scipy():
    """A Butterworth low-pass, and notches, in whose digital width is the sine of the frequency."""
    hz, every = np.array([0.5, 10.0, 24.0, 30.0, 36.0, 49.0]), 1e-2

    def response(**own):
        controller = Controller(design(kp=2.0, every=every, **own))
        answer = [controller.step(STILL | {"error": float(not k)}) for k in range(400)]
        return np.exp(-2j * np.pi * np.outer(hz, every * np.arange(400))) @ answer / 2.0

    plain = freqz(*butter(2, 24.0, fs=1 / every), hz, fs=1 / every)[1]
    np.testing.assert_allclose(response(lowpass_hz=24.0), plain, atol=1e-12)
    width = np.arctan(0.5 * 0.4 * np.sin(2 * np.pi * 30.0 * every)) / np.pi / every
    plain = freqz(*iirnotch(30.0, 30.0 / width, 1 / every), hz, fs=1 / every)[1]
    notch = {"notch_hz": 30.0, "notch_width": 0.4}
    np.testing.assert_allclose(response(**notch, notch_depth=0.0), plain, atol=1e-12)
    # A notch of the depth d is d of the command, and 1 - d of it through a notch of the depth 0.
    deep = response(**notch, notch_depth=0.25)
    np.testing.assert_allclose(deep, 0.25 + 0.75 * plain, atol=1e-12)


def test_it_is_the_filter_of_scipy():
    """A random error through two of them, whose outputs add up."""
    errors = np.random.default_rng(1).normal(size=400)
    pairs = {7.0: (3.0, -40.0), 250.0: (-60.0, 20.0)}
    controller = Controller(design(resonators=[one(x, *pair) for x, pair in pairs.items()]))
    found = [controller.step(STILL | {"error": error}) for error in errors.tolist()]
    each = [lfilter(*filters(*pair, x * EVERY), errors) for x, pair in pairs.items()]
    np.testing.assert_allclose(found, sum(each), atol=1e-12 * np.abs(found).max())


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


@pytest.mark.parametrize("frequencies", [[50.0, 1.0], [3142.0], [float(x) for x in range(1, 10)]])
def test_frequencies_that_cannot_be_told_are_refused_in_a_line(frequencies):
    own = {"controller.linear": {"load_frequencies_rad_s": frequencies}}
    with refused() as found:
        genome_of(api.load_scenario("c-axis-ramp", own))
    assert "controller.linear.load_frequencies_rad_s" in found.refusal


T, PULL, LEFT, BRAKE, DRIVEN, STRAIGHT = 0.01, 30.0, 0.2, 0.5, 2.0, 0.1

#: A position, its velocity, and a current that is fast: p' = p + T v, v' = v + T PULL i + STRAIGHT
#: u, i' = LEFT i - BRAKE v + DRIVEN u.
MODEL = Nominal(
    1.0,
    np.array([[1.0, T, 0.0], [0.0, 1.0, T * PULL], [0.0, -BRAKE, LEFT]]),
    np.array([0.0, STRAIGHT, DRIVEN]),
    {
        "error": np.array([-1.0, 0.0, 0.0]),
        "error_rate": np.array([0.0, -1.0, 0.0]),
        "current": np.array([0.0, 0.0, 1.0]),
    },
    *[Steady(nan, np.full(3, nan))] * 4,
)


def test_what_is_not_measured_is_settled():
    """The current is (DRIVEN u - BRAKE v) / (1 - LEFT)."""
    found, force = measured(MODEL, [], "design"), T * PULL / (1.0 - LEFT)
    assert found.names == ("error", "error_rate")
    np.testing.assert_allclose(found.a, [[1.0, T], [0.0, 1.0 - force * BRAKE]], atol=1e-14)
    np.testing.assert_allclose(found.b, [0.0, -STRAIGHT - force * DRIVEN], atol=1e-14)


def test_what_is_measured_keeps_its_own_motion():
    found = measured(MODEL, None, "design")
    assert found.names == ("error", "error_rate", "current")
    turn = np.diag([-1.0, -1.0, 1.0])
    np.testing.assert_allclose(found.a, turn @ MODEL.a @ turn, atol=1e-14)
    np.testing.assert_allclose(found.b, turn @ MODEL.b, atol=1e-14)


@pytest.mark.parametrize("names", [[], None])
def test_gains_are_those_of_the_riccati_equation(names):
    model, random = measured(MODEL, names, "design"), np.random.default_rng(1)
    b, weights = model.b[:, None], random.uniform(0.1, 10.0, (5, len(model.b)))
    for own, found in zip(weights, regulators(model, weights), strict=True):
        value = solve_discrete_are(model.a, b, np.diag(own**2), np.eye(1))
        wanted = -(b.T @ value @ model.a) / (1.0 + b.T @ value @ b)
        np.testing.assert_allclose(found, wanted[0], rtol=1e-8)
