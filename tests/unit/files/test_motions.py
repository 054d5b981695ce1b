"""Scenarios of several motions: what each inherits, that they are judged as if alone."""

import pytest
from four_motions import MOTIONS, SEVERAL
from wording import refused

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.plausibility import plausibility_warnings


def test_what_a_motion_leaves_out_is_the_scenarios():
    ramp, creep, cut, step = load_scenario(SEVERAL).each_motion()
    assert [x.name for x in (ramp, creep, cut, step)] == [
        "several.ramp",
        "several.creep",
        "several.cut",
        "several.step",
    ]
    assert [x.simulation.duration_s for x in (ramp, creep, cut, step)] == [0.3, 0.2, 0.15, 0.1]
    assert [x.fitness.settled_after_s for x in (ramp, creep, cut, step)] == [1.0, 1.0, 0.1, 1.0]
    assert (cut.reference, cut.load.constant) == (ramp.reference, 5.0)
    assert creep.reference.velocity == 0.002
    assert step.samples().start[0].spindle_angle == 0.001
    assert ramp.each_motion() == (ramp,)


@pytest.mark.parametrize(("duration", "gone"), [(3.0, 0.03), (0.5, 0.03 * 0.499)])
def test_a_copy_begins_off_by_a_hundredth_of_the_way_of_a_second_at_most(duration, gone):
    changes = {"reference.velocity": 0.03, "simulation.duration_s": duration}
    samples = load_scenario("c-axis-ramp", changes).samples()
    (start,), (beside,) = samples.start, samples.copy_start
    assert beside.spindle_angle - start.spindle_angle == pytest.approx(0.01 * gone)
    assert beside.rotor_angle - start.rotor_angle == pytest.approx(0.01 * gone)


def test_one_motion_at_least_is_for_all_machines():
    some = [{**motion, "machines": "nominal"} for motion in MOTIONS]
    found = load_scenario({**SEVERAL, "motions": [*some[:3], MOTIONS[3]]})
    assert found.nominal_only == (True, True, True, False)
    with refused():
        load_scenario({**SEVERAL, "motions": some})


def test_scenarios_without_motions_are_written_as_before():
    plain = load_scenario("c-axis-ramp").model_dump(mode="json", exclude_none=True)
    assert not {"motions", "start", "constraints", "robust"} & plain.keys()
    again = load_scenario(load_scenario(SEVERAL).model_dump(mode="json", exclude_none=True))
    assert again == load_scenario(SEVERAL)


@pytest.mark.parametrize(
    "motion",
    [
        {"simulation": {"sample_time_s": 0.002}},
        {"duration_s": 1e-9},
        {"name": "ramp"},
        {"start": {"angle": 1}},
        {"reference": {"kind": "ramp", "velocity": 1.7e308}, "duration_s": 2},
        {"load": {"axes": {"y": {}}}},
    ],
    ids=str,
)
def test_motions_that_cannot_be(motion):
    wrong = SEVERAL | {"motions": [MOTIONS[0], {"name": "wrong", **motion}]}
    with refused() as found:
        load_scenario(wrong)
    assert found.refusal.startswith("scenario: motions.1")
    assert "\n" not in found.refusal


def test_a_fitness_below_zero_cannot_be_one_of_many():
    with refused():
        load_scenario(SEVERAL | {"fitness": {"kind": "stick-share"}})


#: A move of 60 mm that takes 60 / 150 + 150 / 1000 = 0.55 s.
MOVE = {
    "name": "move",
    "plant": {"name": "positioning-stage"},
    "simulation": {"duration_s": 1.5, "sample_time_s": 0.001},
    "controller": {"kind": "pid+ff"},
    "reference": {"kind": "trapezoidal", "distance": 60, "velocity": 150, "acceleration": 1000},
    "sensors": {"encoder_resolution": 0.001, "velocity": "observer", "observer_hz": 150.0},
    "fitness": {
        "kind": "tolerances",
        "settled_after_s": 0.9,
        "tolerances": {"rms_error": 0.01, "settled_rms_error": "10 um"},
    },
}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"simulation.sample_time_s": 0.05, "sensors.velocity": "tachometer"},
            ["30 samples; with fewer than 80 "],
        ),
        ({"simulation.sample_time_s": 0.01}, ["observer_hz = 150 [Hz]", "50 Hz"]),
        ({"sensors.observer_hz": 2000.0}, ["observer_hz = 2000 [Hz]", "500 Hz"]),
        ({"sensors.observer_hz": 501.0}, ["observer_hz = 501 [Hz]", "500 Hz"]),
        ({"fitness.settled_after_s": 1.5}, ["settled_after_s = 1.5 [s]"]),
        (
            {"simulation.duration_s": 0.3, "fitness.settled_after_s": 0.2},
            ["after 0.3 s of a move of 0.55 s"],
        ),
        # A uniform distribution of 40 um has a standard deviation of 40 / sqrt(12) um.
        ({"sensors.encoder_resolution": 0.04}, ["[mm]", "0.012 mm rms", "tolerances.rms_error"]),
        (
            {"sensors.encoder_resolution": 1.0, "fitness": {"kind": "lin-lee"}},
            ["encoder_resolution = 1 [mm]", "60 mm in total, only 60 such steps"],
        ),
    ],
)
def test_a_wrong_unit_is_doubted(changes, words):
    assert plausibility_warnings(load_scenario(MOVE)) == []
    (line,) = plausibility_warnings(load_scenario(MOVE, changes))
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    "changes",
    [
        {"sensors.observer_hz": 500.0},
        {"simulation.duration_s": 0.55, "fitness.settled_after_s": 0.5},
        {"simulation.duration_s": 0.1, "fitness": {"kind": "lin-lee"}, "reference.distance": 0.5},
    ],
)
def test_what_may_well_be_meant_is_not(changes):
    assert plausibility_warnings(load_scenario(MOVE, changes)) == []


def test_a_motion_is_named():
    motions = [{"name": "whole"}, {"name": "short", "duration_s": 0.4, "settled_after_s": 0.3}]
    (line,) = plausibility_warnings(load_scenario(MOVE, {"motions": motions}))
    assert line.startswith("move.short: the simulation ends after 0.4 s of a move of 0.55 s")
