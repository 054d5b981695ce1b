"""The limit of the rate of a command goes with the design as that of the command does.

The oracle is a ramp counted by hand, and a limit of the rate written down once more with NumPy.
"""

import numpy as np
import pytest
from held_back import LIMITS, commanded_alone

import hfc_design.api as hfc
from hfc_design.files.design import design_json, parse_design
from hfc_design.runtime import Controller

#: u = 2 e - 0.5 de/dt [V], every 5 ms, up to 6 V and 100 V/s: 0.5 V a sample.
RAMP = {
    "controller.pd": {"kp": 2.0, "kd": -0.5},
    "controller.sample_time_s": 0.005,
    "limits": {"command": 6.0, "command_rate": 100.0},
}


def slow(name, samples_to_the_limit=20, **changes):
    """A design that goes from rest to its largest command in so many samples."""
    design = hfc.load_design(name)
    limit = LIMITS[design.plant.name]
    rate = limit / (samples_to_the_limit * design.controller.sample_time_s)
    return hfc.load_design(name, changes | {"limits": {"command": limit, "command_rate": rate}})


def free(design):
    """The same, with commands as fast as they like."""
    return design.model_copy(update={"limits": design.limits.without_rate()})


def by_hand(asked, change):
    found, before = [], 0.0
    for command in asked:
        before = min(max(command, before - change), before + change)
        found.append(before)
    return np.array(found)


def pd(**changes):
    return hfc.load_design("pd-only", RAMP | changes)


@pytest.mark.parametrize(
    ("name", "scenario"),
    [("lin-lee-1999-table-1", "c-axis-step"), ("jee-koren-2004-pid", "feed-drive-line")],
)
def test_the_simulator_keeps_it_by_the_design_alone(name, scenario):
    design = slow(name)
    change = design.limits.command_rate * design.controller.sample_time_s
    found = hfc.evaluate(design, hfc.load_scenario(scenario, {"simulation.duration_s": 1.0}))
    for axis in found.axes:
        commanded_alone(design, axis)
        if name.startswith("lin"):  # whose drive takes a command as it is
            moves = np.abs(np.diff(axis.motion.command, prepend=0.0))
            assert np.isclose(moves, change).sum() > 10
            assert moves.max() <= change * (1.0 + 1e-12)


def test_a_slower_drive_of_a_scenario_bounds_it_further():
    scenario = {"limits": {"command": 5.0, "command_rate": 400.0}, "simulation.duration_s": 0.2}
    step = hfc.load_scenario("c-axis-step", scenario)
    fast = hfc.load_design("lin-lee-1999-table-1", {"limits.command_rate": 4000.0})
    for design in (hfc.load_design("lin-lee-1999-table-1"), fast):
        (axis,) = hfc.evaluate(design, step).axes
        moves = np.abs(np.diff(axis.motion.command, prepend=0.0))
        assert moves.max() == pytest.approx(0.4, rel=1e-12)
        assert np.abs(axis.motion.command).max() == 5.0
    # One that is faster than the controller changes nothing.
    own = hfc.load_design("lin-lee-1999-table-1", {"limits.command_rate": 400.0})
    found, other = (
        hfc.evaluate(own, hfc.load_scenario("c-axis-step", scenario | {"limits": limits}))
        for limits in ({"command_rate": 900.0}, {})
    )
    np.testing.assert_array_equal(found.axes[0].motion.command, other.axes[0].motion.command)


@pytest.mark.parametrize("kind", ["pd", "pd+hierarchical-fuzzy"])
def test_what_a_search_finds_was_searched_with_it_and_keeps_it(kind):
    changes = {
        "limits": {"command": 25.0, "command_rate": 500.0},
        "simulation.duration_s": 0.3,
        "controller": {"kind": kind},
        "search.population": 16,
        "search.generations": 2,
    }
    scenario = hfc.load_scenario("c-axis-ramp", changes)
    run = hfc.design(scenario)
    assert run.design.limits.command_rate == 500.0
    again = hfc.evaluate(parse_design(design_json(run.design), "again"), scenario)
    assert again.merit == run.evaluation.merit
    for found in (run.evaluation, again):
        (axis,) = found.axes
        assert np.abs(np.diff(axis.motion.command, prepend=0.0)).max() <= 0.5 * (1.0 + 1e-12)
    huge = dict.fromkeys(run.design.kind.reads(run.design.controller), 0.0) | {"error": 10.0}
    assert Controller(run.design).step(huge) == 0.5


def test_what_is_learnt_comes_back_without_what_was_commanded():
    design = hfc.load_design("huang-soc", {"limits.command_rate": 40.0})
    scenario = hfc.load_scenario("milling-table-circle", {"simulation.duration_s": 1.0})
    found = hfc.learned_in(design, scenario, hfc.evaluate(design, scenario))
    assert found.limits == design.limits
    both = found.controller.axes.values()
    assert all(own.table != design.controller.table for own in both)
    one, other = (Controller(design, "x") for design in (found, free(found)))
    errors = 0.2 * np.sin(np.arange(100) / 9.0)
    own, asked = (np.array([x.step({"error": e}) for e in errors.tolist()]) for x in (one, other))
    assert np.abs(np.diff(asked)).max() > 0.3
    np.testing.assert_array_equal(own, by_hand(asked, 0.2))
