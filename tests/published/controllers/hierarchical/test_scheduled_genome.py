"""A hierarchy that goes from one linear law to another: what a search makes of it."""

import json

import pytest
from scheduled import of_two_laws

from hfc_design import api

FILES = ("design.json", "history.csv", "checkpoint.npz")


@pytest.mark.parametrize("preset", ["cma", "race"])
def test_stopped_and_resumed_equals_uninterrupted(preset, tmp_path):
    """Stopped in the stage of two laws; cma ends with a law that is scheduled."""
    scenario = of_two_laws()
    scenario = api.load_scenario(
        "c-axis-ramp",
        {
            "controller": scenario.controller.model_dump(mode="json"),
            "search.preset": preset,
            "simulation.duration_s": 0.2,
            "search.population": 12,
            "search.generations": 12,
        },
    )
    whole = api.design(scenario, tmp_path / "whole")

    class Stopped(Exception):
        pass

    def stop(search):
        if search.generation == 7:
            raise Stopped

    with pytest.raises(Stopped):
        api.design(scenario, tmp_path / "parts", stop)
    assert api.design(scenario, tmp_path / "parts").design == whole.design
    for name in FILES:
        again, once = ((tmp_path / run / name).read_bytes() for run in ("parts", "whole"))
        assert again == once
    own = json.loads((tmp_path / "whole" / "design.json").read_text())["controller"]
    assert own["scheduled"]["kp"] != 0.0
