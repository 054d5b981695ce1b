"""The cursor on surfaces of a page: numbers by hand and as hfc explain, in a browser too."""

import json
import re
from math import exp, inf
from pathlib import Path

import numpy as np
import pytest

from hfc_design import api as hfc
from hfc_design.controllers.flc import pictures as fuzzy
from hfc_design.controllers.kind import Shown
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, design_json
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario, scenario_of
from hfc_design.report import page as pages
from hfc_design.runtime.explain import explained, part

LESSON = "docs/lesson.fll"
HOSTILE = "</script><script>document.title = 'x'</script><b>\"'&"
#: Largest part of a page that a unit may take [letters].
LARGEST = 60_000


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


def learnt_soc():
    record = json.loads(design_json(hfc.load_design("huang-soc")))
    table = np.random.default_rng(3).uniform(-2.0, 2.0, (11, 11))
    record["controller"]["table"] = table.tolist()
    return Design.model_validate(record)


def surface_of(design, axis="", unit=0):
    """What a page tells its script of a unit, and the unit of the error in it."""
    own = part(design, axis)
    plant = PlantSettings(**own.plant.model_dump())
    shown_of = Shown(plant.machine, plant.values(), None)
    sections = own.kind.sections(own.controller, shown_of.of(own.axis) if own.axis else shown_of)
    found = [x.cursor for section in sections for x in section.drawings if x.cursor]
    return json.loads(json.dumps(found[unit]))


#: Design, its axis, number of a unit; signals of a sample by column and row as a page shows them.
CASES = {
    "flc": ("jee-koren-2004-flc", "", 0, lambda c, r: {"error": r, "error_change": c}),
    "aflc": ("jee-koren-2004-aflc", "", 0, lambda c, r: {"error": r, "error_change": c}),
    "sliding": ("lin-gai-2009-fuzzy-sliding", "y", 0, lambda c, r: {"error": r, "error_rate": c}),
    "soc": (learnt_soc, "", 0, lambda c, r: {"error": 1e-3 * r, "error_change": 1e-3 * c}),
    "inside": (
        "lin-gai-2009-fuzzy-sliding-compensated",
        "a",
        0,
        lambda c, r: {"error": r, "error_rate": c},
    ),
    "hierarchy": (
        "lin-lee-1999-table-1",
        "",
        0,
        lambda c, r: {
            **dict.fromkeys(("error", "error_rate", "deflection", "deflection_rate"), 0.0),
            "spindle_velocity": 1e-3 * c,
            "previous_spindle_velocity": 1e-3 * r,
        },
    ),
}


def asked(case):
    """Numbers of a unit, places on its surface, and what hfc explain says of each."""
    name, axis, unit, signals = CASES[case]
    design = name() if callable(name) else hfc.load_design(name)
    numbers = surface_of(design, axis, unit)
    random, places = np.random.default_rng(7), []
    for side in ("column", "row"):
        low, high = numbers[side]["ends"]
        places.append([low, high, *random.uniform(low, high, 6).tolist()])
    pairs = [*zip(*places, strict=True)]
    told = []
    for column, row in pairs:
        at = ",".join(f"{key}={x!r}" for key, x in signals(column, row).items())
        told.append(explained(design, [at], axis)["units"][unit])
    return numbers, pairs, told


def same(rules, output, told):
    """Whether these are the rules and the output that hfc explain tells."""
    expected = {(r["row"], r["column"]): (r["share"], r["consequent"]) for r in told["rules"]}
    for rule in rules.keys() | expected.keys():
        found, wanted = rules.get(rule, (0.0, None)), expected.get(rule, (0.0, None))
        assert found[0] == pytest.approx(wanted[0], abs=1e-12)
        if found[0] > 1e-12:
            assert found[1] == wanted[1]
    assert output == pytest.approx(told["output"], rel=1e-12, abs=1e-12)


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


def test_only_a_page_with_surfaces_has_a_script(monkeypatch):
    monkeypatch.setattr(pages, "usable", lambda *_: {}["nobody asks"])
    assert "<script" not in page(hfc.load_design("pd-only"), load_scenario("c-axis-ramp"))
