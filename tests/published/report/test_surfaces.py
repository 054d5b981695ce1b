"""The cursor on surfaces of a page: numbers by hand and as hfc explain, in a browser too."""

import json
import re
from math import exp, inf
from pathlib import Path

import numpy as np
import pytest

from hfc_design import api as hfc
from hfc_design.controllers.flc import pictures as fuzzy
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, design_json
from hfc_design.files.named_scenario import scenario_of
from hfc_design.report import page as pages

LESSON = "docs/lesson.fll"
HOSTILE = "</script><script>document.title = 'x'</script><b>\"'&"


def page(design, scenario):
    """The page of a design, beside no other one."""
    return pages.design_page(design, scenario, "again", {}).html.decode()


@pytest.fixture(scope="module")
def written():
    """The page of the lesson's table, the error of which has a hostile name."""
    design = hfc.import_(LESSON)
    scenario = {
        "name": "short",
        "plant": {"name": "feed-drive"},
        "simulation": {"duration_s": 0.2, "sample_time_s": 0.01},
        "reference": {"kind": "ramp"},
        "controller": {"kind": "flc"},
    }
    record = json.loads(design_json(design))

    def unknown(*_):
        raise UserError("nobody asks")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pages, "usable", unknown)
        patch.setattr(
            fuzzy, "called", lambda name, usual, told: HOSTILE * (told == "error") or told
        )
        return page(Design.model_validate(record), scenario_of(scenario, "short", Path()))


def numbers_in(text):
    """What the page tells its script of each surface."""
    pattern = '(?s)<script type="application/json" class="rules">(.*?)</script>'
    return [json.loads(found) for found in re.findall(pattern, text)]


def degree(term, u):
    """A triangle, or a Gaussian with a flat top."""
    if "sigma" in term:
        return exp(-0.5 * (max(term["low"] - u, u - term["high"], 0.0) / term["sigma"]) ** 2)
    left, right = (term[key] is None for key in ("left", "right"))
    up = inf if left else (u - term["left"]) / (term["centre"] - term["left"])
    down = inf if right else (term["right"] - u) / (term["right"] - term["centre"])
    return max(0.0, min(1.0, up, down))


def fired(numbers, column, row):
    """(row's term, column's term) -> share and consequent; and the output."""
    column, row = (
        {term["label"]: degree(term, side["enters"] * x) for term in side["terms"]}
        for side, x in ((numbers["column"], column), (numbers["row"], row))
    )
    strength = np.outer([*row.values()], [*column.values()])
    shares = strength / strength.sum()
    rules = {
        (a, b): (shares[i, j], numbers["table"][i][j])
        for i, a in enumerate(row)
        for j, b in enumerate(column)
        if strength[i, j]
    }
    return rules, float((shares * numbers["table"]).sum())


def test_the_lesson_by_hand(written):
    """docs/lesson.fll: P is 0.5 at an error of 10 and 1/15 at a change of 1."""
    (numbers,) = numbers_in(written)
    rules, output = fired(numbers, 1.0, 10.0)
    a, b = 0.5 * 14 / 15, 0.5 / 15
    expected = {("Z", "Z"): (a, 0), ("P", "Z"): (a, 60), ("Z", "P"): (b, 60), ("P", "P"): (b, 120)}
    assert rules.keys() == expected.keys()
    for rule, told in expected.items():
        assert rules[rule] == pytest.approx(told)
    assert output == pytest.approx(34.0)
    assert numbers["labels"][1][1:] == ["none", "more"]
    assert numbers["said"] == "command [unit]"
