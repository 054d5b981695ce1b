"""Mistakes in keys of files: a line each, in plain words."""

import json
import time

import pytest
from mistakes import WRONG, mistaken, places, refusals
from plain_words import plain_lines
from wording import refused

from hfc_design.core.records import UserError
from hfc_design.core.validation_errors import MOST
from hfc_design.files.design import design_json, named_design, parse_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.reference.entries import KEY, things


@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "jee-koren-2004-aflc"])
def test_a_wrong_value_in_a_design_is_told_in_plain_words(name):
    """In every key of these two; of all designs: tests/published/core."""
    file = json.loads(design_json(named_design(name)))
    own = [*places(file)]
    texts = map(json.dumps, mistaken(file, own))
    found = refusals(texts, lambda text: parse_design(text, "mine.json"), "mine.json: ")
    assert found > 3 * len(own)


def of_each_kind():
    """One key of a scenario of each type and range, as the reference tells them."""
    found = {}
    for one in things(KEY):
        found.setdefault((one.type, one.allowed), one.key)
    return found.values()


@pytest.mark.parametrize("key", of_each_kind())
def test_a_wrong_value_of_each_kind_of_key_is_told_in_plain_words(key):
    """Keys of one kind have one check; every key of every scenario: tests/published/core."""
    table, _, part = key.partition(".N.")
    changes = ({table: [{part: wrong}] if part else wrong} for wrong in WRONG)
    found = refusals(changes, lambda change: load_scenario("c-axis-ramp", change), "c-axis-ramp: ")
    assert found > 3


def refusal(*scenario):
    """The lines with which a scenario is refused."""
    with pytest.raises(UserError) as found:
        load_scenario(*scenario)
    return plain_lines(found.value)


def test_every_fault_of_a_file_has_a_line():
    changes = ["simulation.duration=3", "seed=1", "search.population=0", "reference.kind=ramps"]
    with refused() as found:
        load_scenario("c-axis-ramp", changes)
    order = ["simulation.duration", "reference.kind", "search.population", "seed"]
    told = [line.split(" = ")[0] for line in plain_lines(found.error)]
    assert told == [f"c-axis-ramp: {key}" for key in order]


def test_a_text_for_a_parameter_hides_no_unknown_name_and_this_no_value():
    own = {"stiffness": "soft", "spindle_mas": 1, "poles": "x"}
    lines = refusal("c-axis-ramp", {"plant.parameters": own})
    assert [line.partition(": ")[2].partition(":")[0] for line in lines] == [
        "plant.parameters.stiffness = 'soft'",
        "plant.parameters.poles = 'x'",
        "plant.parameters.spindle_mas",
    ]
    own = {"spindle_mas": 1, "gear_rato": 1, "stiffness": -1}
    lines = refusal("c-axis-ramp", {"plant.parameters": own})
    keys = [line.partition("plant.parameters.")[2].partition(":")[0] for line in lines]
    assert keys == ["spindle_mas", "gear_rato", "stiffness = -1.0"]


def test_twenty_thousand_unknown_keys_take_no_minutes():
    unknown = {f"durations_{k}": 1.0 for k in range(20_000)}
    begun = time.process_time()
    lines = refusal({"name": "x", **unknown})
    assert time.process_time() - begun < 20.0  # were every one compared with every other: minutes
    assert len(lines) == MOST + 1
    assert "and 19900 more keys with errors" in lines[-1]


def test_what_is_quoted_stays_bounded_and_cannot_move_the_terminal():
    keys = {f"a\nb\x1b[2J{k}{'x' * 1000}": "\x1b[2J" * 1000 for k in range(MOST + 9)}
    lines = refusal({"name": "x"} | keys)
    assert len(lines) == MOST + 1
