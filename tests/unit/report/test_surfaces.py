"""The cursor on surfaces of a page: numbers by hand and as hfc explain, in a browser too."""

import json

import numpy as np

from hfc_design import api as hfc
from hfc_design.controllers.kind import Shown
from hfc_design.files.design import Design, design_json
from hfc_design.files.machine import PlantSettings
from hfc_design.runtime.explain import part


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


def test_the_root_tells_its_share_of_the_command():
    """Table I of Lin & Lee: 10 V for an output of 1; what scales a law commands nothing alone."""
    design = hfc.load_design("lin-lee-1999-table-1")
    assert surface_of(design, unit=3)["worth"] == [10.0, "V"]
    assert surface_of(design, unit=0)["worth"] is None
    assert surface_of(learnt_soc())["worth"] == [5.0, "V"]
