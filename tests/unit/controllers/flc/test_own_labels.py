"""Labels and output terms of an imported table, changed by their keys."""

import json

import pytest
from places import ROOT
from wording import refused

from hfc_design.files.design import parse_design
from hfc_design.files.pairing import load_design
from hfc_design.formats.reading import Wish, imported

LESSON = ROOT / "docs" / "lesson.fll"


@pytest.fixture
def lesson():
    return imported(LESSON, Wish())


@pytest.mark.parametrize("change", ["labels.2.1=forwrd", "centroids.2.1=5", "output_terms.mroe=80"])
def test_what_cannot_be(lesson, change):
    with refused() as found:
        load_design(lesson, [f"controller.rules.{change}"])
    assert f"controller.rules.{change.partition('=')[0]}" in found.refusal


def test_a_mistyped_term_of_one_axis(lesson):
    own = lesson.controller.model_dump(mode="json")
    each = lesson.model_dump(mode="json") | {
        "controller": {"kind": "per-axis", "axes": {"x": own, "y": own}, "sample_time_s": 0.01}
    }
    whole, key = parse_design(json.dumps(each), "both"), "controller.axes.y.rules.output_terms.mroe"
    with refused() as found:
        load_design(whole, {key: 80})
    assert key in found.refusal


def test_the_file_itself_is_no_design_yet():
    with refused():
        load_design(LESSON)
