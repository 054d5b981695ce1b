"""Mistakes in every key of every built-in file: a line each, in plain words."""

import json

import pytest
from mistakes import mistaken, refusals, with_own_places

from hfc_design.files.design import builtin_designs, design_json, named_design, parse_design
from hfc_design.files.named_scenario import builtin_names, load_scenario


def scenarios():
    for name in builtin_names():
        yield name, load_scenario(name).model_dump(mode="json", exclude_none=True)


@pytest.mark.parametrize(("file", "own"), [*with_own_places(scenarios())])
def test_a_wrong_value_in_a_scenario_is_told_in_plain_words(file, own):
    assert refusals(mistaken(file, own), load_scenario) > 3 * len(own)


def designs():
    for name in builtin_designs():
        yield name, json.loads(design_json(named_design(name))) | {"score": {}, "provenance": {}}


@pytest.mark.parametrize(("file", "own"), [*with_own_places(designs())])
def test_a_wrong_value_in_a_design_is_told_in_plain_words(file, own):
    texts = map(json.dumps, mistaken(file, own))
    found = refusals(texts, lambda text: parse_design(text, "mine.json"), "mine.json: ")
    assert found > 3 * len(own)
