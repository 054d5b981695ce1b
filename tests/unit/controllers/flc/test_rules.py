"""Labels and numbers of a rule table, which cannot contradict one another, and its names."""

import json

import made_up
import pytest
from shaken import shaken
from wording import refused

from hfc_design.controllers.flc.rules import nearest_labels
from hfc_design.files.design import design_json, named_design, parse_design

FLC = "jee-koren-2004-flc"


def parsed(design, **rules):
    """The design after other rules were written into its file."""
    data = json.loads(design_json(design))
    data["controller"]["rules"] |= rules
    for key in [key for key, value in rules.items() if value is None]:
        del data["controller"]["rules"][key]
    return parse_design(json.dumps(data), "mine.json").controller.rules


def test_labels_may_be_left_out_and_follow_from_the_numbers():
    """JK04 Table 3: the heights of the seven labels are 1, 1/2, 1/4 of the largest."""
    own = named_design(FLC)
    assert parsed(own, labels=None) == own.controller.rules
    found = parsed(made_up.fuzzy("flc", 1, 2, 3), labels=None, centroids=[[-9, 0, 1], [4, 2.6, 9]])
    assert found.labels == (("NL", "ZR", "ZR"), ("PM", "PS", "PL"))


def test_a_larger_label_cannot_have_a_smaller_number():
    own = named_design(FLC)
    table = [list(row) for row in own.controller.rules.centroids]
    table[1][2] = 9.0  # an NM above the PS of 8
    with refused() as found:
        parsed(own, centroids=table)
    assert "controller.rules.labels.1.2 = 'NM' is 9" in found.refusal
    assert parsed(own, centroids=table, labels=None).labels[1][2] == "PS"
    table[1][2] = -9.0  # between its neighbours
    assert parsed(own, centroids=table).labels == own.controller.rules.labels


def test_a_named_singleton_is_one_number():
    own = made_up.named(2, 2, 3)
    rules = own.controller.rules
    assert parsed(own, centroids=None) == rules
    table = [list(row) for row in rules.centroids]
    table[1][0] += 1.0
    with refused() as found:
        parsed(own, centroids=table)
    assert "rules.centroids.1.0 = " in found.refusal
    with refused() as found:
        parsed(own, labels=[["PL"] * 3] * 2)
    assert "rules.labels.0.0 = 'PL'" in found.refusal


@pytest.mark.parametrize(
    "change",
    [
        {"rules": {"centroids": [[0.0] * 3] * 4}},
        {"names": {"error": "a", "output": "A"}},
        {"names": {"error": "e; DROP"}},
    ],
)
def test_shapes_and_names_that_do_not_fit(change):
    data = json.loads(design_json(made_up.fuzzy("flc", 1, 5, 3)))
    data["controller"] |= change
    with refused() as found:
        parse_design(json.dumps(data), "mine.json")
    assert f"controller.{next(iter(change))}" in found.refusal


def test_a_number_between_two_labels_has_the_lower_one_of_both():
    """12 of 32 is as near to 8 as to 16, but for its last bits."""
    for largest, between in shaken(32.0, 12.0):
        assert nearest_labels([[-largest, -between, between, largest]]) == [
            ["NL", "NM", "PS", "PL"]
        ]
