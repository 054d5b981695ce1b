"""Machines of a spread that diverge are simulated in finer steps."""

import numpy as np
import pytest
from ovens import OVEN, baking

import hfc_design.api as hfc


@pytest.mark.usefixtures("own_plugins")
def test_machines_of_a_spread_are_mended_as_one_is():
    hfc.register(OVEN)
    where = baking(cools=3300.0)
    design = hfc.with_gains(where, "pd", {"kp": 100.0, "kd": 20.0})
    found = hfc.robustness(design, where, 0.2, 40)
    rates = found.machines.actual[0].cools * 1e-3
    growth = np.log10(1 - rates + rates**2 / 2 - rates**3 / 6 + rates**4 / 24)  # of a step
    assert found.refined == (600 * growth > 308.25).sum()  # where a float64 ends
    assert 5 < found.refined < 35
    assert found.stable.all()
    assert found.values["fitness"] == pytest.approx(np.full(40, found.nominal["fitness"]))
