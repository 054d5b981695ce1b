"""What an explanation says: by hand, and as the runtime steps."""

from math import exp

import pytest

from hfc_design.controllers.hierarchical.law import LIN_LEE_TERMS
from hfc_design.files.design import Design
from hfc_design.files.machine import PlantSettings
from hfc_design.runtime import explain


def explanation(design, texts):
    """Of a design for the machine that its file names."""
    plant = PlantSettings(**design.plant.model_dump())
    return explain.explanation(design, plant.machine.drives[0], plant.values()[0], texts)


def test_a_unit_of_a_hierarchy_by_hand():
    """Consequents 10 i + j: the output is 10 times the mean row plus the mean column."""
    table = [[10.0 * i + j for j in range(7)] for i in range(7)]
    design = Design.model_validate(
        {
            "name": "made-up",
            "plant": {"name": "c-axis", "parameters": {}},
            "controller": {
                "kind": "pd+hierarchical-fuzzy",
                "sample_time_s": 0.001,
                "pd": {"kp": 100.0, "kd": 7.0},
                "inputs": [
                    {"name": "error", "scale": 50.0},
                    {"name": "previous_spindle_velocity", "scale": 10.0},
                ],
                "output_scale": 10.0,
                "terms": [term._asdict() for term in LIN_LEE_TERMS],
                "units": [
                    {
                        "id": 0,
                        "column_input": "error",
                        "row_input": "previous_spindle_velocity",
                        "consequents": table,
                    }
                ],
            },
        }
    )
    found = explanation(
        design, ["error=0.004,error_rate=0.5,spindle_velocity=9,previous_spindle_velocity=0.7"]
    )
    # error: u = 0.2; velocity: 7 clamped to 1 (LL eq. 3).
    at_02 = [exp(-4 * 1.1**2), exp(-8 * 0.75**2), exp(-32 * 0.4**2), exp(-32 * 0.2**2), 1.0]
    at_02 += [exp(-8 * 0.35**2), exp(-4 * 0.7**2)]
    at_1 = [exp(-4 * 1.9**2), exp(-8 * 1.55**2), exp(-32 * 1.2**2), exp(-32), exp(-32 * 0.8**2)]
    at_1 += [exp(-8 * 0.35**2), 1.0]
    column, row = (sum(k * d for k, d in enumerate(at)) / sum(at) for at in (at_02, at_1))
    (unit,) = found["units"]
    assert list(unit["column"]["degrees"].values()) == pytest.approx(at_02)
    assert list(unit["row"]["degrees"].values()) == pytest.approx(at_1)
    assert unit["output"] == pytest.approx(10 * row + column)
    assert [(item["scaled"], item["reading"]) for item in found["inputs"]] == [
        (pytest.approx(0.2), 0.004),
        (pytest.approx(7.0), 0.7),
    ]
    best = unit["rules"][0]
    assert (best["row"], best["column"], best["consequent"]) == ("f7", "f5", 64.0)
    assert best["share"] == pytest.approx(1 / (sum(at_02) * sum(at_1)))
    assert sum(rule["share"] for rule in unit["rules"]) == pytest.approx(1.0)
    assert found["parts"] == pytest.approx(
        {"proportional": 0.4, "derivative": 3.5, "fuzzy": 10 * (10 * row + column)}
    )


def test_the_parts_of_a_linear_controller_by_hand():
    own = {"kind": "pid+ff", "sample_time_s": 0.01, "kp": 2.0, "ki": 50.0, "kd": 0.1}
    own["signals"] = {"deflection": -30.0}
    own["feed_forward"] = {"velocity": 10.0, "coulomb": 5.0, "coulomb_width": 0.02}
    plant = {"name": "c-axis", "parameters": {}}
    design = Design.model_validate({"name": "mine", "plant": plant, "controller": own})
    sample = "error=1,error_rate=4,deflection=0.2,reference_rate=0.01,reference_acceleration=3"
    found = explanation(design, [sample, sample])
    assert found["parts"] == pytest.approx(
        {
            "proportional": 2.0,
            "integral": 0.5,  # of the first sample
            "derivative": 0.4,
            "deflection": -6.0,
            "feed-forward of velocity": 0.1,
            "feed-forward of acceleration": 0.0,
            "feed-forward of coulomb": 2.5,
            "feed-forward of load": 0.0,
        }
    )
    assert found["command"] == pytest.approx(-0.5)
    assert found["units_of_signals"]["reference_acceleration"] == "rad/s2"
