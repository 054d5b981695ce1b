"""A motion that diverges is simulated in finer steps, and says when and what ran away."""

import numpy as np
import pytest

import hfc_design.api as hfc
from hfc_design.simulation.divergence import divergence_of, finer


def test_runaway_is_where_a_quantity_leaves_its_size_for_good():
    time = 0.001 * np.arange(1000)
    spike = np.where(np.arange(1000) == 3, 1e9, 1.0)  # comes back
    late = np.where(time < 0.7, 1.0, 2e3)
    later = np.where(time < 0.8, 1.0, np.nan)
    assert divergence_of(time, {"a": spike, "b": later, "c": late}) == (pytest.approx(0.7), "c")
    assert divergence_of(time, {"a": spike}) == (pytest.approx(1.0), "the fitness")
    grown = np.where(time < 0.8, np.exp(np.maximum(time - 0.795, 0.0) * 1e3), np.nan)
    assert divergence_of(time, {"b": later, "d": grown}).cause == "d"


def test_finer_steps_stop_where_they_are_not_allowed():
    steps = [own.simulation.substeps for own in finer(hfc.load_scenario("c-axis-ramp"))]
    assert steps == [4, 16]
    many = hfc.load_scenario("c-axis-ramp", {"simulation.substeps": 100})
    assert [own.simulation.substeps for own in finer(many)] == [400]
