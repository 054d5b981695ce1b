"""Limits of a command and of its rate in whole simulations and searches."""

import numpy as np
import pytest
from held_back import FORMS, by_hand, commanded_alone, free, limited, slow

import hfc_design.api as hfc
from hfc_design.files.design import design_json, parse_design
from hfc_design.runtime import Controller


@pytest.mark.parametrize(
    ("name", "scenario"),
    [
        ("lin-lee-1999-table-1", "c-axis-step"),
        ("adapting hierarchy on a linear part", "c-axis-step"),
    ],
)
def test_the_simulator_keeps_a_limit_by_the_design_alone(name, scenario):
    name, changes = FORMS.get(name, (name, {}))
    design = limited(name, 7.0, **changes)
    found = hfc.evaluate(design, hfc.load_scenario(scenario, {"simulation.duration_s": 1.0}))
    for axis in found.axes:
        commanded_alone(design, axis)
        assert np.abs(axis.motion.command).max() == 7.0


@pytest.mark.parametrize(
    ("name", "scenario"),
    [("lin-lee-1999-table-1", "c-axis-step"), ("jee-koren-2004-pid", "feed-drive-line")],
)
def test_the_simulator_keeps_a_rate_by_the_design_alone(name, scenario):
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
def test_what_a_search_finds_was_searched_with_them_and_keeps_them(kind):
    changes = {
        "limits": {"command": 25.0, "command_rate": 500.0},
        "simulation.duration_s": 0.3,
        "controller": {"kind": kind},
        "search.population": 16,
        "search.generations": 2,
    }
    scenario = hfc.load_scenario("c-axis-ramp", changes)
    run = hfc.design(scenario)
    again = parse_design(design_json(run.design), "again")
    for limits in (run.design.limits, again.limits):
        assert (limits.command, limits.command_rate) == (25.0, 500.0)
    found = hfc.evaluate(again, scenario)
    assert found.merit == run.evaluation.merit
    for (axis,) in (run.evaluation.axes, found.axes):
        assert np.abs(np.diff(axis.motion.command, prepend=0.0)).max() <= 0.5 * (1.0 + 1e-12)
    huge = dict.fromkeys(run.design.kind.reads(run.design.controller), 0.0) | {"error": 10.0}
    assert Controller(run.design).step(huge) == 0.5
    assert Controller(free(run.design)).step(huge) == 25.0


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
