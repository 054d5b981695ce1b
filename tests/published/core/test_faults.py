"""Mistakes in every key of every built-in file: a line each, in plain words."""

import pytest
from plain_words import plain_lines

from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import builtin_names, load_scenario
from hfc_design.files.scenario import Scenario

#: Of no type, or out of every range; one of them is wrong wherever it stands.
WRONG = (None, "mood", -1, 1e300, float("nan"), [], [[["a"]]], {}, {"mood": {"mood": 1}}, True)


def places(value, here=()):
    """Every place in tables, and in the first entry of lists."""
    if here:
        yield here
    if isinstance(value, dict):
        for key, part in value.items():
            yield from places(part, (*here, key))
    elif isinstance(value, list) and value:
        yield from places(value[0], (*here, 0))


def put(data, place, value):
    """The same with another value in a place."""
    if not place:
        return value
    own = put(data[place[0]] if len(place) > 1 else None, place[1:], value)
    if isinstance(data, dict):
        return data | {place[0]: own}
    return [own, *data[1:]]


def mistaken(data, own):
    """The file with a wrong value in one of its ``own`` places after the other."""
    for place in own:
        for wrong in WRONG:
            yield put(data, place, wrong)


def of_kinds(data, place):
    """A place and the kinds of the tables that hold it: a key of another kind is another."""
    kinds = []
    for key in place:
        kinds.append(data.get("kind") if isinstance(data, dict) else None)
        data = data[key]
    return place, *kinds


def with_own_places(files):
    """(file, places that none of those before has): each is tried in one file only."""
    known = set()
    for name, data in files:
        own = [place for place in places(data) if of_kinds(data, place) not in known]
        known.update(of_kinds(data, place) for place in own)
        if own:
            yield pytest.param(data, own, id=name)


def scenarios():
    for name in builtin_names():
        yield name, load_scenario(name).model_dump(mode="json", exclude_none=True)


@pytest.mark.parametrize(("file", "own"), [*with_own_places(scenarios())])
def test_a_wrong_value_in_a_scenario_is_told_in_plain_words(file, own):
    refused = 0
    for data in mistaken(file, own):
        try:
            assert isinstance(load_scenario(data), Scenario)
        except UserError as error:
            plain_lines(error)  # of a program for the axes it is the program's file
            refused += 1
    assert refused > 3 * len(own)
