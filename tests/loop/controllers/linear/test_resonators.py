"""Resonators: by SciPy's filter, on a linear plant by its transfer function, at a limit."""

import numpy as np
import pytest
from linear_designs import EVERY, STILL, design, filters, one, plant
from made_up import limited, linear, resonating
from scipy.linalg import solve_discrete_are
from scipy.signal import cont2discrete, dlsim
from sledge import imported

from hfc_design import api
from hfc_design.controllers.kinds import KINDS
from hfc_design.files.design import Design
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller
from hfc_design.simulation.loop_margins import loop_margins
from hfc_design.stability.margins import margins

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


@pytest.mark.parametrize("degrees", [0.0, -70.0, 70.0])
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
    found = margins(simulated_loop(record))
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
    assert found.phase == pytest.approx(min(lags), abs=0.1)
    assert found.delay == pytest.approx(min(waits), rel=0.01)


def test_an_optimal_loop_is_that_of_scipy(own):
    """LQR of a mass under viscous friction: the closed loop as SciPy solves and simulates it."""
    api.register(imported("mine").SLEDGE)  # m dv/dt = u - 3 v, m = 2
    every, weights = 0.01, {"error": 300.0, "error_rate": 5.0}
    sledge = (np.array([[0.0, 1.0], [0.0, -1.5]]), np.array([[0.0], [0.5]]), np.eye(2), 0)
    a, b, *_ = cont2discrete(sledge, every)
    cost = np.diag([x**2 for x in weights.values()])
    value = solve_discrete_are(a, b, cost, np.eye(1))
    k = np.linalg.solve(1.0 + b.T @ value @ b, b.T @ value @ a)

    genome = KINDS.get("lqr").genome
    settings = {"kind": "lqr", "ranges": {name: [w, w] for name, w in weights.items()}}
    scenario = api.load_scenario(
        {
            "plant": {"name": "sledge"},
            "reference": {"kind": "step", "height": 1.0},
            "simulation": {"duration_s": 1.0, "sample_time_s": every, "substeps": 8},
            "controller": settings,
        }
    )
    made = genome(scenario.controller, scenario.target)
    record = made.record(made.empty())
    assert (record["kp"], record["kd"]) == pytest.approx(tuple(k[0]), rel=1e-9)

    gains = {name: value for name, value in record.items() if name != "kind"}
    (axis,) = api.evaluate(api.with_gains(scenario, "lqr", gains), scenario).axes
    closed = (a - b @ k, b @ k[:, :1], np.eye(2), np.zeros((2, 1)), every)
    outputs = dlsim(closed, np.ones(100))[1]
    np.testing.assert_allclose(axis.motion.error, 1.0 - outputs[:, 0], atol=1e-9)
