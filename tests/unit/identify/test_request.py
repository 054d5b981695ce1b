"""What is looked for, and what somebody knows."""

import numpy as np
import pytest
from carts import CART

from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.request import parameters_of, task_of
from plants import PLANTS


def wanted(plant, changes, names=None):
    return parameters_of(task_of(plant, None, changes, None, None, names, None, 0))


def test_a_load_is_looked_for_where_no_parameter_is_one():
    assert "load" in wanted("milling-table", ()).names
    assert "load" not in wanted("positioning-stage", ()).names
    assert "load" in wanted("positioning-stage", (), ["mass", "load"]).names


def test_what_is_set_is_known_and_listed():
    changes = {"plant.parameters.torque_gain": 2.5, "load.constant": 530, "limits.lag_s": 0.0005}
    found = wanted("milling-table", changes | {"plant.parameters.lead": 10.0})
    assert not {"torque_gain", "load", "lead"} & {*found.names}
    assert found.sought.tolist() == [1.0, 0.0]
    for told in ("load 530 N", "torque_gain 2.5 N m/V", "lead 10 mm/rev"):
        assert told in found.rest()
    assert "table_mass 100 kg" in found.wanted()
    assert "lag_s known to be" in found.wanted()


def test_a_start_is_said_beside_the_name():
    found = wanted("milling-table", (), ["table_mass=180", "load=20"])
    assert found.starts["table_mass"] == 180.0
    assert found.values(found.begun) == pytest.approx([180.0, 20.0])


def test_only_what_units_explain_is_said_to_be_far_from_where_it_began():
    """Machines of 97 times the mass of the built-in stage exist, and of 0.004 times the drag."""
    cart = free_parameters(CART, {}, ("mass", "viscous_friction"))
    for factor, told in ((97.3, 0), (0.0042, 0), (1.5, 0), (1020.0, 1), (1e-3, 1), (1 / 57, 1)):
        numbers = np.append(np.log([factor, 1.0]), [0.0, 0.0])
        assert list(cart.away(numbers)) == ["mass"] * told


def test_what_is_not_looked_for_is_said_with_its_value():
    """A mass beside a wrong gain is wrong by the same factor; exact ones are known."""
    stage = PLANTS["positioning-stage"]
    told = free_parameters(stage, {"offset": -2.0}, ["mass", "coulomb_friction"]).rest()
    assert told.startswith("not identified: ")
    for words in ("amplifier_gain 35.1507 N/V", "offset -2 N", "viscous_friction 203.5 N s/m"):
        assert words in told
    assert "mass" not in told
    every = [name for name in stage.parameters._fields if name not in stage.exact]
    assert free_parameters(stage, {"stiction_rise": 1.0}, every).rest() == ""
