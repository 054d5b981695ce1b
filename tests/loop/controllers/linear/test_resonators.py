"""Resonators: by SciPy's filter, on a linear plant by its transfer function, at a limit."""

import math

import numpy as np
import pytest
from linear_designs import EVERY, STILL, design, filters, one, plant
from made_up import limited, linear, resonating
from scipy.linalg import solve_discrete_are
from sledge import imported
from wording import refused

from hfc_design import api
from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.pid import PidGains, initial_memory, sample
from hfc_design.core.numbers import SCALARS
from hfc_design.files.design import Design, design_json
from hfc_design.files.loop_setup import load_design
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller
from hfc_design.simulation.loop_margins import loop_margins
from hfc_design.stability.margins import margins
from plants import FEED_DRIVE

FREQUENCIES = [5.0, 20.0]


def of_sledge(kind, frequencies=FREQUENCIES, **settings):
    """A genome of a mass under viscous friction, which is linear."""
    api.register(imported("mine").SLEDGE)
    own = {"kind": kind, "load_frequencies_rad_s": frequencies, **settings}
    step = {"kind": "step", "height": 1.0}
    whole = {"plant": {"name": "sledge"}, "reference": step, "controller": own}
    return genome_of(api.load_scenario({**whole, "simulation": {"sample_time_s": EVERY}}))


def simulated_loop(record):
    """The loop of the simulation, at rest."""
    step = {"plant": {"name": "sledge"}, "reference": {"kind": "step", "height": 1.0}}
    scenario = api.load_scenario({**step, "simulation": {"sample_time_s": EVERY}})
    mine = design(**{k: x for k, x in record.items() if k != "weights"}).model_dump(mode="json")
    mine["plant"] = {"name": "sledge", "parameters": {}}
    return loop_margins(Design.model_validate(mine), scenario).rows[0].loop


def simulated(record, load):
    """Errors of the sledge under a load of each sample, in the runtime."""
    a, b = plant()
    controller = Controller(design(**{k: x for k, x in record.items() if k != "weights"}))
    state, errors = np.zeros(2), []
    for force in load.tolist():
        errors.append(-state[0])
        signals = STILL | {"error": -state[0]} | {"error_rate": -state[1]}
        state = a @ state + b * (controller.step(signals) - force)
    return np.array(errors)


def answer(record, angle):
    """Error that a load of 1 at exp(i angle) leaves."""
    loop, place = opened(record, angle)
    return place / (1.0 + loop)


def opened(record, angle):
    """The open loop at exp(i angle) and the place that a force of 1 moves to: closed form.

    The plant is that of SciPy, (z - a)^-1 b by hand.
    """
    z, (a, b) = np.exp(1j * angle), plant()
    speed = b[1] / (z - a[1, 1])
    place = (b[0] + a[0, 1] * speed) / (z - 1.0)
    law = record["kp"] + record["ki"] * EVERY / (z - 1.0)
    for x in record["resonators"]:
        pair = x["in_phase"], x["quadrature"]
        above, below = filters(*pair, EVERY * x["frequency_rad_s"])
        law += np.polyval(above, z) / np.polyval(below, z)
    return law * place + record["kd"] * speed, place


@pytest.mark.parametrize("kind", ["pid+ff", "lqi"])
def test_an_error_of_a_told_frequency_vanishes_and_a_neighbour_s_is_that_of_the_loop(kind, own):
    """The last ten seconds of 40; one 5 % off leaves what the transfer function says."""
    settings = {"ranges": {"derivative_hz": [1e9, 1e9]}} if kind == "pid+ff" else {}
    made = of_sledge(kind, **settings)
    record = made.record(made.empty())
    steps = np.arange(4000)

    def left(frequency):
        errors = simulated(record, np.cos(frequency * EVERY * steps))
        basis = np.exp(1j * frequency * EVERY * steps[-1000:])
        parts = np.stack([basis.real, basis.imag], axis=1)
        return np.hypot(*np.linalg.lstsq(parts, errors[-1000:])[0])

    for frequency in FREQUENCIES:
        without = {**record, "resonators": []}
        size = abs(answer(without, frequency * EVERY))
        assert left(frequency) < 1e-5 * size
        beside = 1.05 * frequency
        expected = abs(answer(record, beside * EVERY))
        assert left(beside) == pytest.approx(expected, rel=1e-4)
        assert 1e-3 * size < expected


@pytest.mark.parametrize("kind", ["lqr", "lqi"])
def test_regulators_with_resonators_are_those_of_scipy(kind, own):
    """States integral, place and speed of the error, two of each resonator, built here."""
    made = of_sledge(kind, ranges={f"resonator_{k}": [0.1, 100.0] for k in (1, 2)})
    population = made.fresh(np.zeros(15, int), np.random.default_rng(2))
    values, gains = made.values(population), made.gains(population)
    a, b = plant()
    size = 7 if kind == "lqi" else 6
    whole, drive = np.zeros((size, size)), np.zeros((size, 1))
    first = size - 6
    whole[first : first + 2, first : first + 2], drive[first : first + 2, 0] = a, -b
    if kind == "lqi":
        whole[0, :2] = 1.0, EVERY
    for k, frequency in enumerate(FREQUENCIES):
        own = first + 2 + 2 * k
        cosine, sine = np.cos(frequency * EVERY), np.sin(frequency * EVERY)
        whole[own : own + 2, own : own + 2] = [[cosine, sine], [-sine, cosine]]
        whole[own, first] = EVERY
    weights = [values["integral"]] if kind == "lqi" else []
    weights += [values["error"], values["error_rate"]]
    for k, frequency in enumerate(FREQUENCIES, 1):
        other = values["integral"] if kind == "lqi" else values["error"] * frequency
        weights += [values[f"resonator_{k}"] * other, np.zeros(15)]
    unit = made.scale  # SciPy loses digits without
    turned, driven = whole * unit[:, None] / unit, drive * unit[:, None]
    for k in range(15):
        cost = np.diag([weight[k] for weight in weights] / unit) ** 2
        value = solve_discrete_are(turned, driven, cost, np.eye(1))
        expected = -np.linalg.solve(1.0 + driven.T @ value @ driven, driven.T @ value @ turned)[0]
        found = [gains.ki[k], gains.kp[k], gains.kd[k], *np.ravel(gains.resonators[:, :, k])]
        within = 1e-6 * np.abs(expected).max()
        np.testing.assert_allclose(found[-size:] / unit, expected, atol=within)


def test_the_simulator_steps_the_same_law():
    """At a limit now and then, sample by sample in the runtime: the same commands."""
    mine = limited(resonating(linear("lqi", 6), 1, 3.0, 200.0), 10.0)
    motion = {"kind": "trapezoidal", "distance": 0.02, "velocity": 0.05, "acceleration": 0.5}
    scenario = api.load_scenario({"reference": motion, "simulation": {"duration_s": 0.3}})
    (axis,) = api.evaluate(mine, scenario).axes
    signals, controller = axis.sensed(), Controller(mine)
    found = [controller.step({k: float(x[i]) for k, x in signals.items()}) for i in range(300)]
    np.testing.assert_allclose(axis.motion.command, found, rtol=1e-9, atol=1e-9)
    assert 0.0 < (np.abs(found) == 10.0).mean() < 1.0


@pytest.mark.parametrize(
    "degrees",
    [
        0.0,
        -70.0,
    ],
)
def test_margins_see_how_a_loop_crosses_one_beside_a_resonance(degrees, own):
    """A resonator of hardly any gain, turned: |L| is 1 within 1e-5 of its frequency alone.

    By a hundred thousand points of the closed form on either side, of which the lags that are left
    are read off.
    """
    made = of_sledge("pid+ff", [200.0], ranges={"resonator_1": [1e-3, 1e-3]})
    record = made.record(made.empty()) | {"derivative_hz": 0.0}
    (before,) = record["resonators"]
    gain = complex(before["in_phase"], before["quadrature"]) * np.exp(1j * np.radians(degrees))
    record |= {"resonators": [one(200.0, gain.real, gain.imag)]}
    found = margins(simulated_loop(record), EVERY)
    lags, waits = [], []
    for way, farthest in ((-1.0, 1.0 - 1e-4), (1.0, 0.57)):  # from next to nothing to half a turn
        angles = 200.0 * EVERY * (1.0 + way * np.geomspace(1e-9, farthest, 200_001))
        values, _ = opened(record, angles)
        crossed = np.flatnonzero(np.diff(np.abs(values) > 1.0))
        ahead = (np.angle(values[crossed], deg=True) + 180.0) % 360.0
        lags += np.minimum(ahead, 360.0 - ahead).tolist()
        waits += (np.radians(ahead) / angles[crossed]).tolist()
    assert found.stable
    assert len(lags) == 3
    assert found.phase_deg == pytest.approx(min(lags), abs=0.1)
    assert found.delay_samples == pytest.approx(min(waits), rel=0.01)


def test_an_error_within_the_dead_zone_counts_as_0():
    """By hand: 2, which no other was before, then 1 and -1 as 0, then -3."""
    design = load_design("jee-koren-2004-pid", {"controller.dead_zone": 1.0})
    controller = Controller(design)
    found = [controller.step({"error": error}) for error in (2.0, 1.0, -1.0, -3.0)]
    integral = 8.1 * 0.01
    assert found == pytest.approx(
        [3.0 + 2 * integral, 2 * integral - 20.0, 2 * integral, -4.5 - integral - 30.0]
    )


def test_a_design_without_a_dead_zone_does_not_name_it():
    assert "dead_zone" not in design_json(load_design("jee-koren-2004-pid"))
    with refused() as found:
        load_design("jee-koren-2004-pid", {"controller.dead_zone": -1})
    assert "controller.dead_zone = -1" in found.refusal


def test_law_by_hand():
    law = AxisLaw(sample, initial_memory, 0.01)
    memory = law.initial_memory(0.0)
    gains = PidGains(1.5, 8.1, 0.1)
    first, memory = law.step(SCALARS, gains, memory, {"error": 2.0})
    assert first == pytest.approx(1.5 * 2 + 8.1 * 0.01 * 2 + 0.1 * 2 / 0.01)
    second, _ = law.step(SCALARS, gains, memory, {"error": 1.0})
    assert second == pytest.approx(1.5 * 1 + 8.1 * 0.01 * 3 - 0.1 * 1 / 0.01)


def test_design_by_hand_is_the_published_one():
    scenario = api.load_scenario("feed-drive-circle", {"simulation.duration_s": 4.0})
    by_hand = api.with_gains(scenario, "pid", {"k_p": 1.5, "k_i": 8.1, "k_d": 0.1})
    published = api.load_design("jee-koren-2004-pid")
    assert by_hand.controller == published.controller
    assert math.isclose(
        api.evaluate(by_hand, scenario).fitness, api.evaluate(published, scenario).fitness
    )


CIRCLE = {"reference": {"kind": "circle", "radius_mm": 5.0, "feed_mm_min": 600.0}}


def test_an_own_plant_needs_ranges_inside_too(own_plugins):
    """A machine of one's own, of drives that the package has."""
    api.register(api.side_by_side("own-table", x=FEED_DRIVE, y=FEED_DRIVE))
    each = {"kind": "per-axis", "axes": {axis: {"kind": "pid"} for axis in "xy"}}
    with refused() as found:
        api.load_scenario({"plant": {"name": "own-table"}, "controller": each, **CIRCLE})
    assert "controller.axes.x.ranges" in found.refusal


def test_the_gains_of_a_pid_make_errors_fade_and_keep_their_frequency(own):
    """To first order: poles at exp(i w T) go inwards by T gain |error of a load of 1| / 2."""
    made = of_sledge(
        "pid+ff", ranges={name: [0.01, 0.01] for name in ("resonator_1", "resonator_2")}
    )
    record = made.record(made.empty()) | {"derivative_hz": 0.0}
    poles = simulated_loop(record).poles()[1]
    for found in record["resonators"]:
        frequency = found["frequency_rad_s"]
        gain = abs(complex(found["in_phase"], found["quadrature"]))
        assert gain == pytest.approx(0.01 * record["kp"] * frequency)
        rate = 0.5 * gain * abs(answer(record | {"resonators": []}, frequency * EVERY))
        near = poles[np.argmin(np.abs(poles - np.exp(1j * frequency * EVERY)))]
        assert -np.log(abs(near)) / EVERY == pytest.approx(rate, rel=0.05)
        assert np.angle(near) / EVERY == pytest.approx(frequency, abs=0.1 * rate)
