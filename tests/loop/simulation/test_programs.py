"""Numbers of a loop are inputs of its compiled program: a program is compiled for a form alone."""

import numpy as np
import pytest

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import compiled
from hfc_design.simulation.ensemble import evaluate_many
from hfc_design.simulation.evaluating import evaluate

PROGRAMS = (compiled.scores, compiled.scores_needed, compiled.trajectories, compiled.jacobians)
FORM = [
    "simulation.duration_s=0.25",
    "fitness.kind=tolerances",
    "fitness.band=1e-5",
    "fitness.settled_after_s=0.1",
    "fitness.tolerances={settled_rms_error=1e-3, band_time=0.2}",
    "limits.command=20",
    "limits.resolution=0.01",
    "limits.command_rate=1e4",
    "sensors.encoder_resolution=1e-6",
    "sensors.noise=1e-7",
    "sensors.velocity=observer",
    "sensors.observer_hz=100",
]
#: Ten values of each number.
NUMBERS = {
    "limits.command": np.linspace(5.0, 14.0, 10),
    "limits.resolution": np.geomspace(1e-3, 1.0, 10),
    "limits.command_rate": np.geomspace(1e3, 2e4, 10),
    "sensors.encoder_resolution": np.geomspace(1e-7, 1e-4, 10),
    "sensors.observer_hz": np.linspace(30.0, 300.0, 10),
    "sensors.noise": np.geomspace(1e-8, 1e-5, 10),
    "fitness.tolerances.settled_rms_error": np.geomspace(1e-5, 1e-2, 10),
    "fitness.tolerances.band_time": np.geomspace(0.01, 1.0, 10),
    "fitness.band": np.linspace(1.40e-3, 1.85e-3, 10),  # of a ramp that is caught up with
    "plant.parameters.stiffness": np.linspace(4e3, 8e3, 10),
}


def compiled_by_now():
    return sum(program._cache_size() for program in PROGRAMS)


def of(*changes):
    return load_scenario("c-axis-ramp", [*FORM, *changes])


def test_ten_values_of_every_number_share_a_program():
    evaluate("pd-only", of())
    before = compiled_by_now()
    for key, values in NUMBERS.items():
        found = set()
        for value in map(float, values):
            one = evaluate("pd-only", of(f"{key}={value!r}"))
            found.add((one.merit, one.axes[0].motion.command.tobytes()))
        assert len(found) == len(values), key  # each was simulated with its own
    assert compiled_by_now() == before


def test_a_limit_is_kept_to_by_the_program_of_another_one():
    for limit in (7.0, 11.5):
        motion = evaluate("pd-only", of(f"limits.command={limit}")).axes[0].motion
        assert np.abs(motion.command).max() == pytest.approx(limit, abs=1e-12)


def test_ten_sample_times_and_weights_share_a_program():
    """Of as many samples; a design has its sample time."""
    design, found = load_design("pd-only"), set()
    before = None
    for k in range(10):
        every = 0.001 * (1.0 + 0.01 * k)
        controller = design.controller.model_copy(update={"sample_time_s": every})
        own = design.model_copy(update={"controller": controller})
        scenario = load_scenario(
            "c-axis-ramp",
            [
                f"simulation.sample_time_s={every!r}",
                f"simulation.duration_s={250 * every!r}",
                f"fitness.error={1.0 + k}",
                "fitness.error_rate=0.2",
            ],
        )
        found.add(evaluate(own, scenario).merit)
        before = before or compiled_by_now()
    assert len(found) == 10
    assert compiled_by_now() == before


@pytest.mark.parametrize(
    "change",
    ["limits.resolution=0", "sensors.velocity=encoder"],
)
def test_what_changes_the_form_takes_another_program_without_a_word(change, recwarn):
    """Without steps of the converter, without an observer."""
    before = compiled_by_now()
    found = evaluate_many("pd-only", of(change))
    assert np.isfinite(found.merit).all()
    assert compiled_by_now() > before
    assert not recwarn.list
