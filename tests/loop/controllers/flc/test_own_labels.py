"""Labels and output terms of an imported table, changed by their keys."""

import pytest
from places import ROOT

from hfc_design.files.pairing import load_design
from hfc_design.formats.reading import Wish, imported
from hfc_design.runtime import Controller

LESSON = ROOT / "docs" / "lesson.fll"


@pytest.fixture
def lesson():
    return imported(LESSON, Wish())


def command(design):
    """At an error of 20 BLU that does not change: rule P, Z alone."""
    controller = Controller(design)
    controller.step({"error": 20.0})
    return controller.step({"error": 20.0})


def test_a_rule_and_what_its_term_stands_for(lesson):
    assert command(lesson) == 60.0
    assert command(load_design(lesson, ["controller.rules.labels.2.1=forward"])) == 120.0
    assert command(load_design(lesson, ["controller.rules.output_terms.more=80"])) == 80.0


def test_a_new_term_that_a_rule_gets_at_once(lesson):
    changes = {"controller.rules.output_terms.big": 90, "controller.rules.labels.2.1": "big"}
    assert command(load_design(lesson, changes)) == 90.0
