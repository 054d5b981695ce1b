"""Scenarios of several motions: what each inherits, that they are judged as if alone."""

import pytest

from hfc_design import api
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario

#: Four motions of different lengths, one with a load, one with a start of its own.
MOTIONS = [
    {"name": "ramp", "duration_s": 0.3},
    {"name": "creep", "reference": {"kind": "ramp", "velocity": 0.002}, "weight": 2.0},
    {"name": "cut", "duration_s": 0.15, "load": {"constant": 5.0}, "settled_after_s": 0.1},
    {
        "name": "step",
        "duration_s": 0.1,
        "reference": {"kind": "step", "height": 0.01},
        "start": {"spindle_angle": 0.001, "rotor_angle": 0.001},
    },
]
SEVERAL = {"name": "several", "simulation": {"duration_s": 0.2}, "motions": MOTIONS}


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


def test_one_motion_at_least_is_for_all_machines():
    some = [{**motion, "machines": "nominal"} for motion in MOTIONS]
    found = load_scenario({**SEVERAL, "motions": [*some[:3], MOTIONS[3]]})
    assert found.nominal_only == (True, True, True, False)
    with pytest.raises(UserError, match="motions: one at least needs machines = 'all'"):
        load_scenario({**SEVERAL, "motions": some})


def test_scenarios_without_motions_are_written_as_before():
    plain = load_scenario("c-axis-ramp").model_dump(mode="json", exclude_none=True)
    assert not {"motions", "start", "constraints", "robust"} & plain.keys()
    again = load_scenario(load_scenario(SEVERAL).model_dump(mode="json", exclude_none=True))
    assert again == load_scenario(SEVERAL)


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        ({"simulation": {"sample_time_s": 0.002}}, "simulation: all motions have the clock of the"),
        ({"sample_time_s": 0.002}, "sample_time_s: all motions have the clock of the scenario"),
        (
            {"duration_s": 1e-9},
            "motions.1: simulation: 1e-09 s in samples of 0.001 s are 0 samples",
        ),
        ({"duration_s": -1}, "motions.1.duration_s = -1: "),
        ({"name": "ramp"}, "motions.1.name = 'ramp': stands there twice"),
        ({"name": "../x"}, "motions.1.name = '../x': "),
        ({"weight": 0}, "motions.1.weight = 0: "),
        ({"start": {"angle": 1}}, "motions.1: start.angle: no state of the machine; did you mean"),
        ({"start": {"x": {"spindle_angle": 1}}}, "motions.1: start.x: no state of the machine"),
        (
            {"reference": {"kind": "circle", "radius_mm": 1, "feed_mm_min": 9}},
            "motions.1: reference",
        ),
        ({"reference": {"kind": "ramp", "velocity": 1.7e308}, "duration_s": 2}, "motions.1: "),
        ({"load": {"axes": {"y": {}}}}, "motions.1: load.axes.y"),
    ],
)
def test_motions_that_cannot_be(motion, message):
    wrong = SEVERAL | {"motions": [MOTIONS[0], {"name": "wrong", **motion}]}
    with pytest.raises(api.UserError) as refusal:
        load_scenario(wrong)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_fitness_below_zero_cannot_be_one_of_many():
    with pytest.raises(api.UserError, match=r"fitness.kind = 'stick-share': may be below zero"):
        load_scenario(SEVERAL | {"fitness": {"kind": "stick-share"}})
