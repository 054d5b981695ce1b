"""Own parts with a field that is missing, of the wrong type, or whose code raises: one line."""

import pytest
from sledge import BUDGET, hfc, imported, refused, scenario_of

from hfc_design import api
from hfc_design.controllers.kinds import KINDS
from hfc_design.core.plugins import know
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.objectives.judge import OBJECTIVES

SMALL = {"simulation.duration_s": 0.1, "search.population": 4, "search.generations": 1}


@pytest.fixture
def sledge(own):
    return imported("mine").SLEDGE


def pd_kind(**changes):
    """A kind as pd, but for some fields, under its own name."""
    return type("Mine", (KINDS.get("pd"),), {"name": "mine"} | changes)


def step(reads):
    """A law of an axis that reads a signal beside the error."""

    def sample(xp, law, gains, memory, signals):
        return gains.kp * signals["error"] + 0.0 * signals[reads], memory, None

    return lambda record, limit: api.AxisLaw(
        sample, lambda law, zero: (), record.sample_time_s, limit
    )


def test_a_law_of_an_axis_reads_what_it_names(own_plugins):
    api.register(pd_kind(law=step("current"), reads=lambda record: ["error", "current"]))
    scenario = api.load_scenario("c-axis-ramp", {"controller": {"kind": "mine"}, **SMALL})
    assert api.design(scenario).design.controller.kind == "mine"


@pytest.mark.usefixtures("own")
def test_what_a_design_needs_is_told_of_every_group(known_use):
    names = {"plant": "SLEDGE", "fitness": "LAST", "controller": "P"}
    whole = [text for key, x in names.items() for text in (f"--{key}", f"mine:{x}")]
    assert hfc("design", "sledge.toml", *whole, "--out", "run", *BUDGET).exit_code == 0
    for group, lacked in names.items():
        for known in (ALL_PLANTS.known, KINDS.known, OBJECTIVES.known):
            for name in ("sledge", "only-p", "last-error"):
                known.pop(name, None)
        used = [
            x for other in names.values() if other != lacked for x in ("--use", f"mine:{other}")
        ]
        for command in ("score", "report"):
            line = refused(command, "run", *used)
            assert f"; its provenance names --use mine:{lacked}" in line, group


def test_a_search_in_which_everybody_failed_says_so(own):
    nothing = imported("mine").LAST._replace(score=lambda sums: sums / 0.0)
    api.register(nothing)
    api.register(imported("mine").P)
    changes = {"fitness": {"kind": "last-error"}, **SMALL}
    with pytest.raises(api.RunError, match=r"diverged \(the fitness is not a number\); try"):
        api.design(api.load_scenario(scenario_of("only-p"), changes))


def test_an_error_in_its_sections_loses_no_search(own):
    (own / "kinds.py").write_text(
        "from hfc_design.controllers.kinds import KINDS\n"
        "class KIND(KINDS.get('pd')):\n"
        "    name = 'mine'\n"
        "    sections = lambda record, shown: 1 / 0\n"
    )
    own_parts = [("plant", "mine:SLEDGE"), ("controller", "kinds:KIND")]
    know(own_parts)
    ranges = {"kp": [1.0, 100.0], "kd": [0.1, 10.0]}
    changes = {"controller": {"kind": "mine", "ranges": ranges}}
    with pytest.raises(api.UserError) as found:
        api.design(api.load_scenario("sledge.toml", changes | SMALL), "run")
    told = "controller 'mine', sections of the report (the design is saved): ZeroDivisionError"
    assert told in str(found.value)
    options = [text for what, name in own_parts for text in (f"--{what}", name)]
    assert told in refused("report", "run", *options)
    assert hfc("score", "run", *options).exit_code == 0
