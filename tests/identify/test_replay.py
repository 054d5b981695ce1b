"""What a replay shifts, and what it takes the load to be between samples."""

import numpy as np
import pytest
from carts import CART

from hfc_design.identify.replay import between, curved, later, rigid
from plants import PLANTS


def shares(drive, **changes):
    return {name: x for name, (_, x) in rigid(drive, drive.parameters(**changes))}


def test_an_axis_goes_as_one_body_through_its_gears():
    """The rotor turns gear_ratio times as far, the nut as far as the table, without backlash."""
    c_axis = PLANTS["c-axis"]
    assert shares(c_axis) == pytest.approx({"spindle_angle": 1.0, "rotor_angle": 1.0})
    assert shares(c_axis, gear_ratio=2.0) == pytest.approx(
        {"spindle_angle": 1.0, "rotor_angle": 2.0}
    )
    table = PLANTS["milling-table"]
    assert shares(table) == pytest.approx({"position": 1.0, "motor_position": 1.0})
    assert shares(CART) == pytest.approx({"position": 1.0})
    assert dict(rigid(c_axis, c_axis.parameters()))["rotor_angle"][0] == "rotor_velocity"


def test_a_load_that_swings_is_not_cut_short():
    """Four points know its middle to the fourth order; straight lines are off by (w T)^2 / 8."""
    every, w = 1e-3, 50.0
    time = every * np.arange(200)
    load = np.sin(w * time)
    rise, bend = between(load)
    middle = curved(load, rise, bend, 0.5)[1:-2]
    exact = np.sin(w * (time + 0.5 * every))[1:-2]
    straight = (load + 0.5 * rise)[1:-2]
    assert np.abs(straight - exact).max() == pytest.approx((w * every) ** 2 / 8, rel=0.01)
    assert np.abs(middle - exact).max() < 1e-3 * (w * every) ** 2
    np.testing.assert_allclose(curved(load, rise, bend, 1.0)[:-1], load[1:], atol=1e-15)


def test_a_command_that_acts_later():
    command = np.array([1.0, 3.0, 2.0, 2.0])
    np.testing.assert_allclose(later(command, 1.0), [1.0, 1.0, 3.0, 2.0])
    np.testing.assert_allclose(later(command, 0.25), [1.0, 2.5, 2.25, 2.0])
