"""Own plants, fitnesses and control laws: how they come in, and what they compute."""

import json
from functools import cache

import made_up
import pytest
from sledge import imported, scenario_of
from structured_text import FunctionBlock

from hfc_design import api
from hfc_design.files.design import design_json
from hfc_design.formats import FORMATS, code
from hfc_design.formats.connection import connect
from hfc_design.formats.st import text_of
from hfc_design.runs.individuals import design_with

#: Formats of any design; parameters of a control are of a pid.
ANY = [to for to, form in FORMATS.items() if not form.parameters]


@pytest.mark.parametrize("target", ANY)
def test_formats_take_an_own_kind_or_refuse_it_in_a_line(own, target):
    api.register(imported("mine").P)
    design = api.with_gains(api.load_scenario(scenario_of("only-p")), "only-p", {"p": 3.0})
    if target in ("csv", "fll", "fcl", "fcl-jfuzzylogic", "fml", "fis"):  # of rules
        with pytest.raises(api.UserError, match="kind only-p"):
            api.export(design, target, "out")
        assert not (own / "out").exists()
    else:
        assert api.export(design, target, "out").stat().st_size > 0


def test_code_of_an_own_law_commands_what_its_formula_does(own):
    api.register(imported("mine").P)
    design = api.with_gains(api.load_scenario(scenario_of("only-p")), "only-p", {"p": 3.0})
    assert code.signals(design) == {"error": "rad"}
    connected = connect(design)
    block, known = FunctionBlock(text_of(connected)), code.flat(connected)
    told = dict.fromkeys(known.inputs, 0.0) | {"reference": 0.5, "spindle_angle": 0.2}
    told |= dict.fromkeys(known.truths, False)
    assert block.step(**told) == 0.0
    assert block.step(**told | {"enable": True}) == pytest.approx(0.9)


@cache
def hierarchy():
    """The file of a hierarchy for the sledge, which has to be known."""
    controller = made_up.hierarchy(1, 2).controller.model_dump_json()
    own = json.loads(controller.replace("spindle_velocity", "speed"))
    return design_json(design_with(own, api.load_scenario("sledge.toml")))


@pytest.mark.parametrize("target", ANY)
def test_formats_take_an_own_plant(own, target):
    api.register(imported("mine").SLEDGE)
    (own / "found.json").write_text(hierarchy())
    assert api.export(api.load_design("found.json"), target, "out").exists()
