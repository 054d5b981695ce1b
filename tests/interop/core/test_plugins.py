"""Own plants, fitnesses and control laws: how they come in, and what they compute."""

import json
from functools import cache

import made_up
import pytest
from sledge import imported, scenario_of

from hfc_design import api
from hfc_design.files.design import design_json
from hfc_design.formats import FORMATS
from hfc_design.runs.individuals import design_with


@pytest.mark.parametrize("target", FORMATS)
def test_formats_take_an_own_kind_or_refuse_it_in_a_line(own, target):
    api.register(imported("mine").P)
    design = api.with_gains(api.load_scenario(scenario_of("only-p")), "only-p", {"p": 3.0})
    if target in ("json", "mat", "fmu-plant"):  # the last holds nothing of a controller
        assert api.export(design, target, "out").stat().st_size > 0
    else:
        with pytest.raises(api.UserError, match="kind only-p"):
            api.export(design, target, "out")
        assert not (own / "out").exists()


@cache
def hierarchy():
    """The file of a hierarchy for the sledge, which has to be known."""
    controller = made_up.hierarchy(1, 2).controller.model_dump_json()
    own = json.loads(controller.replace("spindle_velocity", "speed"))
    return design_json(design_with(own, api.load_scenario("sledge.toml")))


#: Formats with a machine in C, which an own one has not.
SIMULATED = ("fmu-loop", "fmu-plant", "linuxcnc")


@pytest.mark.parametrize("target", [name for name in FORMATS if name not in SIMULATED])
def test_formats_take_an_own_plant(own, target):
    api.register(imported("mine").SLEDGE)
    (own / "found.json").write_text(hierarchy())
    assert api.export(api.load_design("found.json"), target, "out").exists()
