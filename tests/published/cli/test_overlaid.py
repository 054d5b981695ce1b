"""hfc plot of several: motions of designs, and searches, over one another."""

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.report.overlaid import motions
from hfc_design.simulation.evaluating import evaluate

SHORT = "simulation.duration_s=0.5"


def evaluated(scenario, *names, changes=(SHORT,)):
    where = load_scenario(scenario, changes)
    return {name: evaluate(load_design(name), where) for name in names}


def lines(axes):
    return {line.get_label(): line for line in axes.lines}


def test_what_runs_away_does_not_hide_the_others():
    kept = evaluated("c-axis-ramp", "pd-only")["pd-only"]
    wild = load_design("pd-only", {"controller.pd.kd": 1e7})
    away = evaluate(wild, load_scenario("c-axis-ramp", [SHORT]))
    assert away.diverged
    figure = motions({"kept": kept, "away": away}, "")
    low, high = figure.axes[1].get_ylim()
    error = 1e3 * kept.axes[0].motion.error
    assert (low, high) == pytest.approx((error.min(), error.max()), abs=0.06 * np.ptp(error))
    assert "away (diverged)" in lines(figure.axes[1])
