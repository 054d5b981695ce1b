"""The one import of scripts: names are taken wherever records are, and refused in one line."""

import numpy as np
import pytest

import hfc_design.api as hfc
from hfc_design.controllers.kinds import KINDS
from hfc_design.objectives.judge import OBJECTIVES
from plants.feed_drive import FEED_DRIVE

CONTOUR = OBJECTIVES.get("lin-lee")
SHORT = {"simulation.duration_s": 0.1}
FOUND = hfc.load_design("pd-only")
RAMP = hfc.load_scenario("c-axis-ramp", SHORT)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: hfc.evaluate(3, RAMP), "an int is no design, nor the name of one"),
        (lambda: hfc.evaluate(RAMP, RAMP), "a Scenario is no design, nor the name of one"),
        (lambda: hfc.evaluate(FOUND, FOUND), "a Design is no scenario, nor the name of one"),
        (lambda: hfc.evaluate("c-axis-ramp", RAMP), "c-axis-ramp: no such design; built in are"),
        (lambda: hfc.evaluate(FOUND, "pd-only"), "pd-only: no such scenario; built in are"),
        (lambda: hfc.evaluate_many([FOUND, None], RAMP), "a NoneType is no design"),
        (lambda: hfc.design(None), "a NoneType is no scenario"),
        (lambda: hfc.Controller(3.0), "a float is no design"),
        (lambda: hfc.export({}, "json", "x"), "a dict is no design"),
        (lambda: hfc.register(3), "3 is none of controller"),
        (lambda: hfc.load_scenario(RAMP, 5), "changes have to be texts as in 'simulation.dura"),
        (lambda: hfc.load_scenario(RAMP, [5]), "changes have to be texts"),
        (lambda: hfc.load_scenario("c-axis-rmp"), r"c-axis-rmp: no such scenario; did you mean c-"),
        (lambda: hfc.load_design("pd-only", 5), "changes have to be texts as in 'controller.int"),
        (lambda: hfc.load_design("pd-onyl"), r"pd-onyl: no such design; did you mean pd-only\?"),
        (lambda: hfc.design("c-axis-ramp", 5), "an int is no path"),
        (lambda: hfc.pick(5), "an int is no path"),
        (lambda: hfc.compare([FOUND, 5]), "an int is no design"),
        (lambda: hfc.robustness(FOUND, RAMP, "x", 10), "spread='x': has to be a number"),
        (lambda: hfc.robustness(FOUND, RAMP, 0.2, "x"), "samples='x': has to be a whole"),
        (lambda: hfc.evaluate_many(FOUND, RAMP, [5]), "an int is no machine: parameters"),
        (lambda: hfc.learned_in(FOUND, RAMP, "x"), "a str is no evaluation; evaluate"),
        (lambda: hfc.trajectory_csv("pd-only"), "a str is no evaluation; evaluate"),
        (lambda: hfc.plot(FOUND, "a.png"), "a Design is no evaluation; evaluate"),
        (lambda: hfc.comparison_page("pd-only", "a.html"), "a str is no comparison; compare"),
        (lambda: hfc.with_gains(RAMP, "pd", 5), "an int is no table of gains"),
        (
            lambda: hfc.with_gains(RAMP, "pid+ff", {"kp": 1, "signals": {"speed": 2}}),
            "controller 'pid.ff': .* 'speed', no signal of the plant 'c-axis'; there is error, ",
        ),
        (lambda: hfc.explain("jee-koren-2004-flc", 3), "an int is no sample: a text, or a mapping"),
        (lambda: hfc.export(FOUND, ["c"], "a"), r"\['c'\] is no format; there is c"),
        (lambda: hfc.export(FOUND, "json", 5), "an int is no path"),
        (lambda: hfc.Scenario(name="x", plnt={}), "Scenario: plnt = {}: there is no such"),
        (lambda: hfc.Scenario(name="a b"), "Scenario: name = 'a b': has to be 1 to 64"),
        (lambda: hfc.evaluate(hfc.Taught(FOUND, 0, 0, "V"), RAMP), r".*; its \.design is one"),
    ],
)
def test_what_is_neither_is_refused_in_a_line(call, told):
    with pytest.raises(hfc.UserError, match=f"^{told}") as refused:
        call()
    assert "\n" not in str(refused.value)


def test_a_way_to_judge_many_that_there_is_not():
    judged = hfc.Judgements(np.arange(6.0).reshape(1, 2, 3), None, None)
    assert judged.kept("mean") == 2.5
    assert judged.kept("worst") == 0.0
    assert judged.kept("quantile", 0.5) == 2.0
    with pytest.raises(hfc.UserError, match=r"'nonsense' is no way .* mean, quantile, worst"):
        judged.kept("nonsense")


def test_only_public_names_are_listed():
    assert dir(hfc) == sorted(hfc.__all__)
    assert len(hfc.__all__) == len({*hfc.__all__})
    assert not [name for name in hfc.__all__ if not hasattr(hfc, name)]


def test_a_registered_part_is_shown_in_a_few_words():
    """A cell of a notebook ends with ``hfc.register(...)``, and shows what it gives."""
    machine = hfc.side_by_side(x=FEED_DRIVE, y=FEED_DRIVE)
    for thing in (FEED_DRIVE, machine, KINDS.get("pd"), hfc.strategies["race"], CONTOUR):
        assert repr(thing).startswith(f"{type(thing).__name__}({thing.name!r}")
        assert len(repr(thing)) < 80


@pytest.mark.parametrize(
    ("tolerances", "told"),
    [
        (
            {"stifness": 0.1},
            r"robust\.tolerances\.stifness: no parameter of c-axis; did you mean",
        ),
        ({"stiffness": 1.5}, r"robust\.tolerances\.stiffness = 1\.5: has to be less than 1"),
    ],
)
def test_tolerances_are_checked_where_a_scenario_is_read(tolerances, told):
    with pytest.raises(hfc.UserError, match=told):
        hfc.load_scenario({"name": "x", "robust": {"tolerances": tolerances}})


@pytest.mark.parametrize("wrong", [True, False, 2])
def test_a_delay_is_a_number_of_samples(wrong):
    with pytest.raises(hfc.UserError, match=f"delay_samples = {wrong}: has to be 0 or 1"):
        hfc.load_scenario(RAMP, {"limits.delay_samples": wrong})
