"""Machines within tolerances: a Latin hypercube, tolerances of single parameters."""

import pytest

from hfc_design import api
from hfc_design.files.machine import PlantSettings
from hfc_design.simulation.machines import drawn

C_AXIS = PlantSettings()


def shares(machines, name):
    """How far a parameter of each machine but the nominal one is from that, as a share of it."""
    (axis,) = machines.true
    values = getattr(axis, name)
    return values[1:] / values[0] - 1.0


def test_a_parameter_has_a_tolerance_of_its_own():
    tolerances = {"stiffness": 0.5, "rotor_inertia": 0.01}
    machines, _ = drawn(C_AXIS, 0.2, 300, 0, tolerances)
    widths = {name: abs(shares(machines, name)).max() for name in ("stiffness", "rotor_inertia")}
    assert 0.45 < widths["stiffness"] <= 0.5
    assert 0.009 < widths["rotor_inertia"] <= 0.01
    assert 0.18 < abs(shares(machines, "spindle_inertia")).max() <= 0.2
    assert (shares(machines, "poles") == 0.0).all()


def test_the_first_machines_of_a_seed_stay():
    some, more = (drawn(C_AXIS, 0.2, count, 7)[0] for count in (5, 40))
    for few, many in zip(some.true[0], more.true[0], strict=True):
        assert few.tolist() == many[:6].tolist()


def test_an_unknown_parameter():
    for key, told in (
        ("--spread", "tolerances: "),
        ("robust.spread", "robust.tolerances."),
    ):
        with pytest.raises(api.UserError, match=f"{told}mass: no parameter of c-axis"):
            drawn(C_AXIS, 0.2, 3, 0, {"mass": 0.1}, key=key)
