"""A hierarchy that goes from one linear law to another: what a search makes of it."""

import json

import pytest

from hfc_design import api

NAMES = ("reference_rate", "error", "spindle_velocity")
SCALE = 50.0
FILES = ("design.json", "history.csv", "checkpoint.npz")


def scenario_of(names=NAMES, **changes):
    own = {
        "inputs": [{"name": name, "scale": SCALE} for name in names],
        "output_scale": 2.0,
        "linear": {"expected_load": 5.0, "load_frequencies_rad_s": [1.0, 50.0]},
        "schedules": True,
        **changes,
    }
    small = {"simulation.duration_s": 0.2, "search.population": 12, "search.generations": 8}
    return api.load_scenario("c-axis-ramp", {"controller": own, "search.preset": "cma", **small})


@pytest.mark.parametrize("preset", ["cma", "race"])
def test_stopped_and_resumed_equals_uninterrupted(preset, tmp_path):
    """Stopped in the stage of two laws; cma ends with a law that is scheduled."""
    scenario = scenario_of()
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
