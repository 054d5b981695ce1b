"""Own parts with a field that is missing, of the wrong type, or whose code raises: one line."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Literal

import pytest
from sledge import api_text, imported, refused

from hfc_design import api
from hfc_design.controllers.kinds import KINDS

SMALL = {"simulation.duration_s": 0.1, "search.population": 4, "search.generations": 1}


def why_not(thing):
    """The one line with which a part is refused."""
    with pytest.raises(api.UserError) as error:
        api.register(thing)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.fixture
def sledge(own):
    return imported("mine").SLEDGE


FUNCTIONS = ("fault", "initial_state", "step", "signals", "accepted")


@pytest.mark.parametrize("value", [None, 5])
def test_every_field_of_a_drive_is_what_its_annotation_says(value, sledge):
    for field in FUNCTIONS:
        line = why_not(replace(sledge, **{field: value}))
        assert line == f"plant 'sledge': {field} = {value}: has to be a function"
    for field in ("units", "encoders"):
        line = why_not(replace(sledge, **{field: value}))
        assert line.startswith(f"plant 'sledge': {field} = {value}: has to be")
    assert f"plant '{value}': name = {value}" in why_not(replace(sledge, name=value))


def test_what_a_drive_names_exists(sledge):
    assert "exact: no parameter is called 'nope'" in why_not(replace(sledge, exact={"nope"}))
    assert "gives [0.0]" in why_not(replace(sledge, signals=lambda p, x: [x.place]))
    api.register(replace(sledge, exact={"mass"}))


def test_a_step_gives_back_the_record_that_it_was_given(sledge):
    state = type(sledge.initial_state(0.0))

    def why(after):
        line = why_not(replace(sledge, step=lambda c, x, force, loads, dt: after(x)))
        head = "plant 'sledge': step has to return the record State with place, speed, each a float"
        assert line.startswith(f"{head}: ")
        return line.removeprefix(f"{head}: ")

    assert why(lambda x: x._asdict()) == "it returns a dict"
    assert why(lambda x: None) == "it returns None"
    assert why(lambda x: x._replace(speed=1)).startswith("speed is int")
    assert why(lambda x: state((x.place,), x.speed > 0.0)) == "place is a tuple, speed is bool"
    api.register(
        replace(sledge, step=lambda c, x, force, loads, dt: 1 / 0)
    )  # simulated, it is told


def test_what_its_functions_raise_names_them(sledge):
    line = why_not(replace(sledge, signals=lambda p: {}))
    assert line.startswith("plant 'sledge': signals: TypeError: ")
    line = why_not(api.coupled(sledge, lambda fixed, states, commands: 1 / 0, name="two"))
    where = rf"\({Path(__file__).name}, line \d+, lambda\)"
    assert re.fullmatch(f"plant 'two': forces: ZeroDivisionError: division by zero {where}", line)


def test_machines_of_drives(sledge):
    other = replace(sledge, name="other")
    both = api.register(api.side_by_side(x=sledge, y=other))
    assert both.name == "sledge-other"
    assert api.coupled(sledge, lambda fixed, states, commands: (0.0,)).axes == ("axis",)
    for wrong in (api.side_by_side(x=5), api.side_by_side(x=both)):
        assert "drives" in why_not(wrong)
    assert "a drive for each of its axes" in why_not(api.side_by_side())
    assert why_not(5).startswith("5 is none of ")


class Weights(api.ObjectiveSettings):
    effort: float = 1.0


def test_fields_of_objectives_and_strategies(own):
    last = imported("mine").LAST
    assert "make = 5: has to be a function" in why_not(last._replace(make=5))
    assert "fitness '5': name = 5" in why_not(last._replace(name=5))
    race = api.strategies["race"]
    assert "strategy 'None': name = None" in why_not(race._replace(name=None))
    own_make = last._replace(make=lambda own: last._replace(unit=str(own.effort)))
    api.register(own_make)
    with pytest.raises(api.UserError, match="fitness 'last-error': make: AttributeError"):
        api.load_scenario("c-axis-ramp", {"fitness": {"kind": "last-error"}})
    api.register(own_make._replace(settings=Weights))
    found = api.load_scenario("c-axis-ramp", {"fitness": {"kind": "last-error"}})
    assert found.judge().objectives[0].unit == "1.0"


def pd_kind(**changes):
    """A kind as pd, but for some fields, under its own name."""
    return replace(KINDS.get("pd"), **{"name": "mine", "c": None, "st": None} | changes)


class Other(api.ControllerRecord):
    kind: Literal["other"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        *(({key: 5}, f"{key} = 5") for key in ("gains", "law", "genome", "of_gains", "sections")),
        *(({key: 5}, f"{key} = 5") for key in ("reads", "c", "record", "settings")),
        ({"gains": None}, "gains = None: has to be a function"),
        ({"name": None}, "controller 'None': name = None"),
        ({"name": 5}, "controller '5': name = 5"),
        ({"of_gains": None}, "genome_of_gains needs of_gains"),
        ({"record": Other}, "name has to be the kind of its Other, 'other'"),
    ],
)
def test_fields_of_a_kind(changes, words, own_plugins):
    assert words in why_not(pd_kind(**changes))


def step(reads):
    """A law of an axis that reads a signal beside the error."""

    def sample(xp, law, gains, memory, signals):
        return gains.kp * signals["error"] + 0.0 * signals[reads], memory, None

    return lambda record, limit: api.AxisLaw(
        sample, lambda law, zero: (), record.sample_time_s, limit
    )


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"law": step("current")},
            "controller 'mine': its law reads 'current', which its reads does not name",
        ),
        (
            {"reads": lambda record: ["error", "wobble"]},
            "controller 'mine': reads 'wobble', no signal of the plant 'c-axis'",
        ),
        (
            {"law": lambda record, limit: 1 / 0},
            "controller 'mine', a step of its law: ZeroDivisionError: division by zero",
        ),
        ({"of_gains": lambda gains: {"pd": {"kp": 1.0}}}, "kind 'mine': controller.pd.kd: is miss"),
    ],
)
def test_a_law_does_a_step_before_a_search_and_when_a_design_is_loaded(changes, line, own):
    api.register(pd_kind(**changes))
    scenario = api.load_scenario("c-axis-ramp", {"controller": {"kind": "mine"}, **SMALL})
    with pytest.raises(api.UserError) as error:
        api.design(scenario)
    assert line in str(error.value)
    if "of_gains" not in changes:
        design = json.loads(api_text("pd-only"))
        design["controller"]["kind"] = "mine"
        (own / "mine.json").write_text(json.dumps(design))
        assert line in refused("score", "mine.json")


def test_a_law_that_is_registered_again_is_the_same_key_of_compiled_code(own):
    law = imported("mine").P
    record = KINDS.add(law).record(kind="only-p", sample_time_s=0.01, gains={"p": 3.0})
    one, other = (KINDS.add(law).law(record, 2.0) for _ in range(2))
    assert one == other
    assert hash(one) == hash(other)


def test_numbers_with_a_unit_meet_those_of_an_own_plant(sledge):
    """The units that a user's own record of it says."""
    api.register(replace(sledge, name="told-sledge", parameter_units={"mass": "kg"}))
    parts = {"plant": {"name": "told-sledge", "parameters": {"mass": "4000 g"}}}
    with pytest.raises(api.UserError) as error:
        api.load_scenario(parts | {"limits": {"command": "10 A"}, "load": {"constant": "2 kN"}})
    assert str(error.value).splitlines() == [
        "scenario: plant.parameters.mass = '4000 g': has to be a number [kg], without the unit: 4",
        "scenario: load.constant = '2 kN': has to be a number [N], without the unit: 2000",
        "scenario: limits.command = '10 A': has to be a number [N]",
    ]
