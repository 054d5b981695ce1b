"""Surfaces of a page that a cursor asks, and what ``hfc explain`` says of the same places."""

import json
from pathlib import Path

import numpy as np
import pytest
from places import ROOT
from report_pages import unknown

from hfc_design import api as hfc
from hfc_design.controllers.flc import section as fuzzy
from hfc_design.controllers.kind import ReportContext
from hfc_design.files.design import Design, design_json
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import scenario_of
from hfc_design.report import page as pages
from hfc_design.runtime.explain import explained, part

HOSTILE = "</script><script>document.title = 'x'</script><b>\"'&"


def page(design, scenario):
    """The page of a design, beside no other one; nobody asks whether it can be used."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pages, "usable", unknown)
        return pages.design_page(design, scenario, "again", {}).html.decode()


def lesson():
    """The page of the lesson's table, the error of which has a hostile name."""
    design = hfc.import_(ROOT / "docs" / "lesson.fll")
    scenario = {
        "name": "short",
        "plant": {"name": "feed-drive"},
        "simulation": {"duration_s": 0.2, "sample_time_s": 0.01},
        "reference": {"kind": "ramp", "velocity": 100.0},
        "controller": {"kind": "flc"},
    }

    def called(name, usual, told):
        return HOSTILE * (told == "error") or told

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fuzzy, "called", called)
        own = Design.model_validate(json.loads(design_json(design)))
        return page(own, scenario_of(scenario, "short", Path()))


def learnt_soc():
    record = json.loads(design_json(hfc.load_design("huang-soc")))
    table = np.random.default_rng(3).uniform(-2.0, 2.0, (11, 11))
    record["controller"]["table"] = table.tolist()
    return Design.model_validate(record)


def surface_of(design, axis="", unit=0):
    """What a page tells its script of a unit, and the unit of the error in it."""
    own = part(design, axis)
    plant = PlantSettings(**own.plant.model_dump())
    shown_of = ReportContext(plant.machine, plant.values(), None)
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
