"""Own parts with a field that is missing, of the wrong type, or whose code raises: one line."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Literal

import pytest
from sledge import api_text, imported
from wording import refused, refused_command

from hfc_design import api
from hfc_design.controllers.kinds import KINDS

SMALL = {"simulation.duration_s": 0.1, "search.population": 4, "search.generations": 1}


def why_not(thing):
    """The one line with which a part is refused."""
    with refused() as found:
        api.register(thing)
    assert "\n" not in found.refusal
    return found.refusal


@pytest.fixture
def sledge(own):
    return imported("mine").SLEDGE


FIELDS = "fault", "initial_state", "step", "signals", "accepted", "units", "encoders"


@pytest.mark.parametrize("value", [None, 5])
def test_every_field_of_a_drive_is_what_its_annotation_says(value, sledge):
    for field in FIELDS:
        line = why_not(replace(sledge, **{field: value}))
        assert line.startswith(f"plant 'sledge': {field} = {value}: ")
    assert f"plant '{value}': name = {value}" in why_not(replace(sledge, name=value))


@pytest.mark.parametrize(
    "text",
    [
        "m*/",
        "N\nm",
        "??/",
    ],
)
def test_a_unit_can_end_no_comment(text, sledge):
    line = why_not(replace(sledge, units=sledge.units | {"command": text}))
    assert line.startswith(f"plant 'sledge': the unit {text!r} must be ")
    why_not(replace(sledge, parameter_units={"mass": text}))


def test_what_code_says_of_a_drive_is_a_name_or_a_line(sledge):
    why_not(replace(sledge, meanings={"speed": "up\n*/"}))
    why_not(replace(sledge, units=sledge.units | {"speed; x": "m"}))
    why_not(api.side_by_side(**{"x; y": sledge}))
    odd = sledge.units | {"command": "% (°C·N²)/µΩ", "load": "1/min"}
    api.register(replace(sledge, units=odd, meanings={"command": '*/ "<b>'}))


def test_a_step_gives_back_the_record_that_it_was_given(sledge):
    state = type(sledge.initial_state(0.0))

    for after in (
        lambda x: x._asdict(),
        lambda x: None,
        lambda x: x._replace(speed=1),
        lambda x: state((x.place,), x.speed > 0.0),
    ):
        own = replace(sledge, step=lambda c, x, force, loads, dt, after=after: after(x))
        assert "step must return the record State with " in why_not(own)
    api.register(
        replace(sledge, step=lambda c, x, force, loads, dt: 1 / 0)
    )  # simulated, it is told


def test_what_its_functions_raise_names_them(sledge):
    line = why_not(replace(sledge, signals=lambda p: {}))
    assert line.startswith("plant 'sledge': signals: TypeError: ")
    with pytest.raises(api.UserError) as raised:
        api.register(api.coupled(sledge, lambda fixed, states, commands: 1 / 0, name="two"))
    line = str(raised.value)
    where = rf"\({Path(__file__).name}, line \d+, lambda\)"
    assert re.fullmatch(f"plant 'two': forces: ZeroDivisionError: division by zero {where}", line)


def test_machines_of_drives(sledge):
    other = replace(sledge, name="other")
    both = api.register(api.side_by_side(x=sledge, y=other))
    assert both.name == "sledge-other"
    assert api.coupled(sledge, lambda fixed, states, commands: (0.0,)).axes == ("axis",)
    for wrong in (api.side_by_side(x=5), api.side_by_side(x=both)):
        why_not(wrong)
    why_not(api.side_by_side())
    why_not(5)


class Weights(api.ObjectiveSettings):
    effort: float = 1.0


def test_fields_of_objectives_and_strategies(own):
    last = imported("mine").LAST
    why_not(last._replace(make=5))
    why_not(last._replace(name=5))
    why_not(api.strategies["race"]._replace(name=None))
    own_make = last._replace(make=lambda own: last._replace(unit=str(own.effort)))
    api.register(own_make)
    with pytest.raises(api.UserError, match="fitness 'last-error': make: AttributeError"):
        api.load_scenario("c-axis-ramp", {"fitness": {"kind": "last-error"}})
    api.register(own_make._replace(settings=Weights))
    found = api.load_scenario("c-axis-ramp", {"fitness": {"kind": "last-error"}})
    assert found.judge().objectives[0].unit == "1.0"


def pd_kind(**changes):
    """A kind as pd, but for some fields, under its own name."""
    return type("Mine", (KINDS.get("pd"),), {"name": "mine"} | changes)


@pytest.mark.parametrize(
    "changes",
    [
        *({key: 5} for key in ("law", "genome", "of_gains", "sections")),
        *({key: 5} for key in ("reads", "settings", "name")),
        *({key: None} for key in ("name", "of_gains")),
    ],
    ids=str,
)
def test_fields_of_a_kind(changes, own_plugins):
    why_not(pd_kind(**changes))


def test_a_kind_without_its_gains_is_refused(own_plugins):
    class Bare(api.ControllerRecord):
        kind: Literal["bare"] = "bare"

        def law(self, limit):
            return step("error")(self, limit)

    why_not(Bare)


def step(reads):
    """A law of an axis that reads a signal beside the error."""

    def sample(xp, law, gains, memory, signals):
        return gains.kp * signals["error"] + 0.0 * signals[reads], memory, None

    return lambda record, limit: api.AxisLaw(
        sample, lambda law, zero: (), record.sample_time_s, limit
    )


@pytest.mark.parametrize(
    "changes",
    [
        {"law": step("current")},
        {"reads": lambda record: ["error", "wobble"]},
        {"of_gains": lambda gains: {"pd": {"kp": 1.0}}},
    ],
)
def test_a_law_does_a_step_before_a_search_and_when_a_design_is_loaded(changes, own):
    api.register(pd_kind(**changes))
    scenario = api.load_scenario("c-axis-ramp", {"controller": {"kind": "mine"}, **SMALL})
    with refused() as found:
        api.design(scenario)
    if "of_gains" not in changes:  # its mistake is in a search alone
        design = json.loads(api_text("pd-only"))
        design["controller"]["kind"] = "mine"
        (own / "mine.json").write_text(json.dumps(design))
        assert found.refusal in refused_command("score", "mine.json")


def test_numbers_with_a_unit_meet_those_of_an_own_plant(sledge):
    """The units that a user's own record of it says."""
    api.register(replace(sledge, name="told-sledge", parameter_units={"mass": "kg"}))
    parts = {"plant": {"name": "told-sledge", "parameters": {"mass": "4000 g"}}}
    with refused() as found:
        api.load_scenario(parts | {"limits": {"command": "10 A"}, "load": {"constant": "2 kN"}})
    keys = [line.split(" = ")[0] for line in found.refusal.splitlines()]
    wanted = ("plant.parameters.mass", "load.constant", "limits.command")
    assert keys == [f"scenario: {key}" for key in wanted]


def test_what_a_drive_names_exists(sledge):
    why_not(replace(sledge, exact={"nope"}))
    why_not(replace(sledge, signals=lambda p, x: [x.place]))
    api.register(replace(sledge, exact={"mass"}))


def test_a_law_that_raises_is_named(own):
    api.register(pd_kind(law=lambda record, limit: 1 / 0))
    with pytest.raises(api.UserError, match="'mine', a step of its law: ZeroDivisionError"):
        api.design(api.load_scenario("c-axis-ramp", {"controller": {"kind": "mine"}, **SMALL}))
