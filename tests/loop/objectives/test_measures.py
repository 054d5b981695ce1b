"""Measures that add up while a loop runs, against NumPy on its recorded motion."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import controller_of, load_design
from hfc_design.objectives.measures import MEASURES, measure
from hfc_design.objectives.objective import Moment
from hfc_design.simulation import population
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.evaluating import evaluate

#: A move to 20 mrad and a hold; it is to be settled after 1.5 s.
MOVE = {
    "name": "move",
    "reference": {"kind": "trapezoidal", "distance": 0.02, "velocity": 0.02, "acceleration": 0.2},
    "simulation": {"duration_s": 2.0},
    "fitness": {"settled_after_s": 0.5},
    "limits": {"command": 9.0},
    "load": {"constant": -5.0},
}
SPEEDS = "spindle_velocity", "rotor_velocity"


def measured(design, scenario, measures):
    """Of the only machine, in float64."""
    found = load_scenario(scenario)
    controller, gains = controller_of(load_design(design), found)
    loop = closed_loop(found, controller)
    loop = loop._replace(judge=loop.judge._replace(measured=tuple(measures)))
    machines = population.one_machine(found.plant.values())
    judged = population.scores(loop, machines, [found.samples()], gains, np.float64)
    return judged.values[0, 0, 0, -len(measures) :]


@pytest.mark.parametrize("gain", [1.0, 2.0])
def test_what_a_disturbance_of_the_start_leaves_is_that_of_two_motions(gain):
    """Of one that settles, and of one beyond the limit of its gain."""
    design = load_design("pd-only", [f"controller.pd.k{x}={750 * gain}" for x in "pd"])
    off = 0.01 * 0.02  # a hundredth of the way of the move
    begun = {"rotor_angle": off, "spindle_angle": off}
    one, other = (evaluate(design, MOVE | {"start": start}).axes[0] for start in ({}, begun))

    def apart(*names):
        """By half of the last quarter; the spindle counts in full, the rotor half."""
        parts = [
            share * (getattr(other.motion.state, x) - getattr(one.motion.state, x)) / off
            for share, x in zip((1.0, 0.5), names, strict=True)
        ]
        return sum(parts)[-500:].reshape(2, 250)

    place, speed = apart("spindle_angle", "rotor_angle"), apart(*SPEEDS)
    swing = np.hypot(place.std(axis=1), 0.01 * speed.std(axis=1))  # ten samples are 10 ms
    growth = min(x.std(axis=1)[1] / x.std(axis=1)[0] for x in (place, speed))
    expected = swing[1] * np.clip(growth, 1.0, 10.0)
    (found,) = measured(design, MOVE, [measure("unsettled")])
    assert found == pytest.approx(expected, rel=1e-6)


def unsettled(rate, period, phase=0.0, offset=0.0, size=1.0):
    """Of a swing of a ``size`` in the end that grows by e^(rate t), in a quarter of 0.6 s."""
    time, own = np.arange(-600, 0) * 1e-3, measure("unsettled")
    turn = (2j * np.pi / period if period else 0.0) + rate
    swing = size * np.exp(turn * time + 1j * phase)
    late = np.repeat([1.0, 2.0], 300)
    moment = Moment(*[jnp.zeros(())] * 6, sample_time=jnp.asarray(1e-3))

    def one(sums, row):
        apart, speed, half = row
        here = moment._replace(apart=apart, apart_rate=speed, late=half)
        return own.update(sums, (here,), None), None

    with jax.enable_x64(True):
        rows = (offset + swing.real, (turn * swing).real, late)
        sums, _ = jax.lax.scan(one, own.initial(jnp.zeros(())), rows)
        return float(own.value(sums))


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.0, 3.0])
def test_what_decays_counts_by_what_is_left_of_it(phase):
    """At e^(-3 t) the last half begins with 2.46 and ends with 1."""
    for period in (0.2, 0.3, 0.4, 0.5):
        assert 0.6 < unsettled(-3.0, period, phase) < 1.4
        assert unsettled(-3.0, period, phase, size=0.1) < 0.14


def test_contour_error_and_vectors_of_two_axes():
    """A circle: the errors of the page's metrics, which are read off the recorded motion."""
    circle = load_scenario("feed-drive-circle", {"simulation.duration_s": 8.0})
    names = ("rms_contour_error", "max_contour_error", "rms_error", "peak_command")
    names += ("path_error", "worst_glitch")
    found = measured("jee-koren-2004-pid", circle, [measure(x) for x in names])
    rms, most, vector, peak, quiet, glitch = found
    evaluation = evaluate("jee-koren-2004-pid", circle)
    x, y = (axis.motion for axis in evaluation.axes)
    assert vector == pytest.approx(np.sqrt(np.mean(x.error**2 + y.error**2)))
    assert peak == max(abs(x.command).max(), abs(y.command).max())
    off = evaluation.contour.error
    # The measure linearises about where the machine should be, the page finds the nearest point.
    assert rms == pytest.approx(np.sqrt(np.mean(off**2)), rel=1e-3)
    assert most == pytest.approx(abs(off).max(), rel=1e-3)
    assert quiet == pytest.approx(evaluation.metrics["path_error_BLU"], rel=1e-3)
    assert glitch == pytest.approx(evaluation.metrics["worst_glitch_BLU"], rel=1e-3)
    assert 0.0 < quiet < glitch


def test_nothing_counts_where_nothing_slides():
    still = MOVE | {"reference": {"kind": "step", "height": 0.001}}
    assert measured("pd-only", still, [MEASURES["stick_slip"]]) == 0.0
