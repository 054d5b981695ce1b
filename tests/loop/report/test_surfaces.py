"""The cursor on surfaces of a page: numbers by hand and as hfc explain."""

import json
import re
from math import exp, inf

import numpy as np
import pytest
from surfaces import CASES, asked, learnt_soc, lesson, page, same, surface_of

from hfc_design import api as hfc
from hfc_design.files.named_scenario import load_scenario

#: Largest part of a page that a unit may take [letters].
LARGEST = 60_000


@pytest.fixture(scope="module")
def written():
    return lesson()


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


@pytest.mark.parametrize("case", CASES)
def test_it_is_what_explain_says(case):
    numbers, places, told = asked(case)
    for (column, row), own in zip(places, told, strict=True):
        same(*fired(numbers, column, row), own)


def test_a_page_is_safe_and_grows_little(written):
    assert "<b>" not in written
    assert written.count("</script>") == 2
    units = re.findall(r'(?s)<div class="surface">.*?</script>', written)
    assert len(units) == 1
    assert len(units[0]) < LARGEST


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


def test_only_a_page_with_surfaces_has_a_script():
    scenario = load_scenario("c-axis-ramp", {"simulation.duration_s": 0.5})
    assert "<script" not in page(hfc.load_design("pd-only"), scenario)


def test_the_root_tells_its_share_of_the_command():
    """Table I of Lin & Lee: 10 V for an output of 1; what scales a law commands nothing alone."""
    design = hfc.load_design("lin-lee-1999-table-1")
    assert surface_of(design, unit=3)["worth"] == [10.0, "V"]
    assert surface_of(design, unit=0)["worth"] is None
    assert surface_of(learnt_soc())["worth"] == [5.0, "V"]
