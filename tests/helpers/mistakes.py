"""Files with a mistake in one of their places after the other."""

import pytest
from plain_words import plain_lines

from hfc_design.core.records import UserError

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


def refusals(files, read, start=""):
    """How many of these files are refused, each in plain words that begin with ``start``."""
    refused = 0
    for data in files:
        try:
            read(data)
        except UserError as error:
            plain_lines(error, start)
            refused += 1
    return refused
