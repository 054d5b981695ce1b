"""The limit of a command goes with the design: into the simulator, the runtime, C and ST.

The oracle of the anti-windup is a PID written down once more with NumPy.
"""

import hfc_design.api as hfc
from hfc_design.files.design import design_json, parse_design
from hfc_design.runtime import Controller


def test_what_a_search_finds_holds_the_scenario_s_limit():
    changes = {
        "limits.command": 25.0,
        "simulation.duration_s": 0.3,
        "controller": {"kind": "pd"},
        "search.population": 16,
        "search.generations": 2,
    }
    design = hfc.design(hfc.load_scenario("c-axis-ramp", changes)).design
    assert design.limits.command == 25.0
    assert parse_design(design_json(design), "again").limits.command == 25.0
    huge = {"error": 10.0, "error_rate": 0.0}
    assert Controller(design).step(huge) == 25.0
