"""Windows, shares and bounds of round numbers: whatever their last bits, also in float32."""

import numpy as np
import pytest
from shaken import shaken

from hfc_design.files.named_scenario import load_scenario
from hfc_design.motion.phases import Window, settled_samples, slides
from hfc_design.motion.samples import Simulation
from hfc_design.objectives.constraints import Constraint
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.metrics import RUNNING
from hfc_design.objectives.verdict import Ensemble
from hfc_design.simulation.acceptance import broken_by, missed
from hfc_design.simulation.stability_criteria import instabilities


@pytest.mark.parametrize("every", [0.0001, 0.0003, 0.0007, 0.001, 0.002, 0.01])
def test_a_window_has_the_samples_that_it_says(every):
    for first, last in ((3, 7), (57, 290), (281, 1001), (1, 5003)):
        ends = (float(f"{k * every:.9g}") for k in (first, last))
        for period, start, end in shaken(every, *ends):
            simulation = Simulation(duration_s=5100 * period, sample_time_s=period)
            window = Window(name="part", from_s=start, to_s=end)
            assert window.part(simulation) == slice(first, last)
            time = simulation.time
            assert settled_samples(time, start).tolist() == [k >= first for k in range(len(time))]


def test_a_motion_that_ends_when_it_is_to_settle_is_looked_at_as_a_whole():
    for period, after in shaken(0.1, 0.7):  # 7 * 0.1 is more than 0.7
        assert settled_samples(period * np.arange(8), after).all()


def test_half_the_largest_speed_is_half_of_it():
    for speeds in shaken(10.0, 5.0, 5.0, 4.9):
        assert slides(np.array([*speeds, 0.0])).tolist() == [True, True, True, False, False]


def bounded(values, most):
    """Of one machine in one motion, what is measured beside merits of 1."""
    merit, table = np.ones((len(values), 1, 1)), np.array(values, float)[:, None, None, None]
    found = Judged(merit, np.concatenate([merit[..., None], table], axis=-1), merit < 0.0)
    return Ensemble((1.0,), (Constraint(RUNNING["peak_command"], most),)).verdict(found)


@pytest.mark.parametrize("most", [0.1, 0.3, 0.7, 10.0])
def test_a_command_at_its_limit_keeps_to_it_in_float32(most):
    given = [x for (x,) in shaken(most)]
    found = bounded([*given, np.float32(most), 1.001 * most], most)
    assert found.sound[:, 0].tolist() == [True] * (len(given) + 1) + [False]
    assert (found.rank[:-1] == 1.0).all()


def test_a_command_at_its_limit_breaks_and_misses_nothing():
    changes = {"constraints.peak_command": 0.1, "limits.command": 0.1}
    scenario = load_scenario("c-axis-ramp", changes)
    values = np.zeros((2, 1, 6))  # three that are told, the constrained one last, and of stability
    values[:, 0, 2] = np.float32(0.1), 0.1001
    found = broken_by(scenario, Judged(np.ones((2, 1)), values, np.zeros((2, 1), bool)))
    assert found["exceeds peak_command"].ravel().tolist() == [False, True]
    told = {"asked_of": "all", "tolerances": {}}
    for value, misses in ((float(np.float32(0.1)), 0), (0.1001, 1)):
        told["tolerances"]["peak_command"] = {"allowed": 0.1, "median": value}
        assert len(missed({"ramp": told})) == misses


def test_what_is_stable_is_not_told_by_how_float32_rounds():
    """A tenth of the last quarter at a limit; an axis that never moves, off by all of its way."""
    for way in (0.1, 0.3, 0.7):
        changes = {"reference": {"kind": "step", "height": way}, "simulation.duration_s": 0.1}
        scenario = load_scenario("c-axis-ramp", changes)
        rows = np.array(
            [[0.0, 0.0, np.float32(way)], [0.0, np.float32(0.1), np.float32(0.05 * way)]]
        )
        found = instabilities(rows[:, None, :], np.zeros((2, 1), bool), [scenario])
        assert not any(mask.any() for mask in found.values())


@pytest.mark.parametrize(("share", "others", "kept"), [(0.29, 100, 29), (0.57, 100, 57)])
def test_a_share_of_the_machines_is_as_many_as_it_says(share, others, kept):
    """0.29 * 100 is less than 29."""
    values = np.zeros((1, others + 1, 1))
    values[0, 1 : kept + 1] = 1.0
    merit = np.ones_like(values)
    found = Judged(merit, np.stack([merit, values], axis=-1), merit < 0.0)
    ensemble = Ensemble((1.0,), (Constraint(RUNNING["stick_slip"], 0.0),), forgiven=share)
    assert ensemble.verdict(found).rank == pytest.approx([1.0])
    assert ensemble.best_rank(found, others + 1) == pytest.approx([1.0])


def test_a_quantile_is_the_machine_that_it_says():
    """0.29 of 100 others are 29 below it, and 1 - 0.29 of them as many above."""
    values = np.arange(101.0)[None, :, None, None]
    one = Ensemble((1.0,), keep="quantile", quantile=0.29)
    assert one.costs(values).ravel().tolist() == [71.0]
    found = Judged(1.0 + values[..., 0], 1.0 + values, values[..., 0] < 0.0)
    assert one.verdict(found).rank == pytest.approx([30.0])


def test_an_axis_that_comes_back_goes_nowhere():
    """But for rounding: beyond where it ends it would be anywhere on one of the sides."""
    scenario = load_scenario("milling-table-circle")
    for axis in scenario.samples().axes:
        assert np.ptp(axis.target) > 1.0
        assert not axis.heading.any()
