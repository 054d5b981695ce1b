"""Labels and output terms of an imported table, changed by their keys."""

import json

import pytest
from places import ROOT

from hfc_design.core.records import UserError
from hfc_design.files.design import parse_design
from hfc_design.files.pairing import load_design
from hfc_design.formats.reading import Wish, imported

LESSON = ROOT / "docs" / "lesson.fll"


@pytest.fixture
def lesson():
    return imported(LESSON, Wish())


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("labels.2.1=forwrd", "labels.2.1 = 'forwrd': is no output term; did you mean forward"),
        ("centroids.2.1=5", "change labels.2.1 to another or output_terms.more"),
        ("output_terms.mroe=80", "output_terms.mroe: no rule has this output term; did you mean"),
    ],
)
def test_what_cannot_be(lesson, change, told):
    with pytest.raises(UserError) as refused:
        load_design(lesson, [f"controller.rules.{change}"])
    assert told in str(refused.value)


def test_a_mistyped_term_of_one_axis(lesson):
    own = lesson.controller.model_dump(mode="json")
    each = lesson.model_dump(mode="json") | {
        "controller": {"kind": "per-axis", "axes": {"x": own, "y": own}, "sample_time_s": 0.01}
    }
    whole = parse_design(json.dumps(each), "both")
    with pytest.raises(UserError, match=r"controller.axes.y.rules.output_terms.mroe: no rule"):
        load_design(whole, {"controller.axes.y.rules.output_terms.mroe": 80})


def test_the_file_itself_is_no_design_yet():
    with pytest.raises(UserError, match=r"is a controller of another program; hfc import "):
        load_design(LESSON)
