"""Mistakes in every key of every built-in file: a line each, in plain words."""

import pytest
from plain_words import plain_lines

from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import builtin_names, load_scenario


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


def tables(value, here=()):
    """Every place of a table."""
    for place in [here, *places(value)]:
        own = value
        for key in place:
            own = own[key]
        if isinstance(own, dict):
            yield place


#: Whose keys are the user's own: names of parameters, axes, measures, states, signals.
OPEN = {"parameters", "axes", "start", "constraints", "readings", "tolerances", "ranges", "limits"}


@pytest.mark.parametrize("name", builtin_names())
def test_an_unknown_key_in_any_table_of_a_scenario_meets_what_is_allowed_there(name):
    whole = load_scenario(name).model_dump(mode="json", exclude_none=True)
    for place in tables(whole):
        if OPEN & {*place}:
            continue
        told = refusal(lambda place=place: load_scenario(put(whole, (*place, "nmae"), 3)))
        key = ".".join(map(str, (*place, "nmae")))
        (line,) = [line for line in told if key in line]
        assert f"scenario: {key} = 3: there is no such key; " in line
        assert "there is " in line.partition("no such key; ")[2]


def refusal(call):
    """The lines of what a call refuses."""
    with pytest.raises(UserError) as refused:
        call()
    return plain_lines(refused.value)
