"""A design in a loop with a plant that it was not made for."""

from math import pi

import pytest
from wording import refused

from hfc_design.files.design import Design
from hfc_design.files.design_set import differences
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.transfer import transfer_report
from hfc_design.simulation.evaluating import evaluate

SHORT = {
    "reference.distance": 25.0,
    "simulation.duration_s": 0.6,
    "robust.spread": 0.1,
    "robust.tolerances": {"mass": 0.2},
}
TURN = 2.0 * pi / 5.0  # [rad/mm] of the screw
#: The stage of EMPS as two masses joined stiffly: its force, mass, viscous and Coulomb friction.
STAGE = {
    "torque_gain": 35.1507 / (1e3 * TURN),
    "motor_inertia": 20.0 / (1e6 * TURN * TURN),
    "table_mass": 75.11,
    "motor_damping": 0.2035 / (1e3 * TURN * TURN),
    "viscous_friction": 1e-9,
    "motor_friction": 20.39 / (1e3 * TURN),
    "stiffness": 1e6,
    **dict.fromkeys(("backlash", "coulomb_friction", "stiction_rise"), 0.0),
}


def made_with() -> Design:
    """The cascade of EMPS, whose provenance has a scenario with a machine and its tolerances."""
    design = load_design("emps-cascade")
    where = own_scenario(design, "it", SHORT | {"plant.parameters": {"offset": 0.0}})
    told = {"scenario": where.model_dump(mode="json", exclude_none=True)}
    return design.model_copy(update={"provenance": design.provenance | told})


def test_on_two_masses_it_moves_as_on_the_one_that_they_are_together():
    design = made_with()
    one = evaluate(design, own_scenario(design, "it")).metrics
    found = {}
    for name, table in {"alike": {}, "heavier": {"table_mass": 400.0}}.items():
        plant = {"plant.name": "milling-table", "plant.parameters": STAGE | table}
        two = own_scenario(design, "it", plant)
        found[name] = evaluate(design, two).metrics
    assert two.robust.tolerances == {}  # mass is no parameter of a table
    errors = ("rms_error_mm", "max_error_mm")
    assert [found["alike"][x] for x in errors] == pytest.approx([one[x] for x in errors], rel=0.01)
    assert found["heavier"]["max_error_mm"] > 1.5 * one["max_error_mm"]
    assert (
        "  machine  this scenario's: milling-table (made for positioning-stage)"
        in transfer_report(design, two)
    )
    told = "made for the plant positioning-stage, here milling-table"
    assert told in [*differences(design, two, two)]


@pytest.mark.parametrize("other", ["c-axis", "five-axis", "feed-drive"])
def test_a_plant_that_counts_otherwise_is_refused(other: str):
    with refused() as found:
        own_scenario(made_with(), "it", {"plant.name": other})
    assert "error must be in mm" in found.refusal


def test_a_plant_without_a_signal_is_refused():
    design = made_with()
    reading = design.controller.model_copy(update={"signals": {"motor_velocity": -0.2}})
    table = design.plant.model_copy(update={"name": "milling-table"})
    two = design.model_copy(update={"controller": reading, "plant": table})
    with refused() as found:
        own_scenario(two, "it", {"plant.name": "positioning-stage"})
    assert "reads 'motor_velocity'" in found.refusal
