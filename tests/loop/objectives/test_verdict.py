"""One number of many motions and machines, against numbers by hand."""

import pytest

from hfc_design import api


def test_constraints_of_a_scenario_are_in_the_units_of_its_machine():
    limits = {"late_error": "2 mrad", "chatter": 3, "band_time": "0.5 s", "band": "50 urad"}
    scenario = api.load_scenario({"constraints": limits})
    most = {one.measure.name: one.most for one in scenario.ensemble.constraints}
    assert most == pytest.approx({"late_error": 2e-3, "chatter": 3.0, "band_time": 0.5})
    feed = {"plant": {"name": "feed-drive"}, "simulation": {"sample_time_s": 0.01}}
    feed |= {"controller": {"kind": "pid"}, "constraints": {"late_error": "20 um"}}
    (late,) = api.load_scenario(feed).ensemble.constraints
    millimetres = api.load_scenario(feed).plant.each()[0].length
    assert late.most == pytest.approx(0.02 / millimetres)
