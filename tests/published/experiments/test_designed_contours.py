"""The kept designs of contours, on paths and machines that no search has seen."""

import numpy as np
import pytest
from places import ROOT

import hfc_design.api as hfc
from experiments.designed_contours.table_page import METRICS, OWN, versus
from hfc_design.simulation.comparison import DesignStatistics

FOLDER = ROOT / "experiments" / "designed_contours"
SMALL = "milling-table-small-circle"


def figures(design, scenario=SMALL, **changes):
    """Path error, impulse and rms [mm]."""
    metrics = hfc.evaluate(design, hfc.load_scenario(scenario, changes)).metrics
    return [metrics[key] for key in METRICS]


@pytest.fixture(scope="module")
def designed():
    return figures(FOLDER / "table.json")


@pytest.mark.parametrize("other", ["huang-pid", "huang-soc", FOLDER / "table-expert-pid.json"])
def test_the_designed_table_is_better_on_a_circle_that_no_search_saw(designed, other):
    assert all(mine < theirs for mine, theirs in zip(designed, figures(other), strict=True))


def test_the_best_figures_of_the_paper_are_beaten_too(designed):
    """Its network on the circle of 25 mm: 0.007 and 0.02 mm."""
    path, impulse, _ = designed
    assert path < 0.007
    assert impulse < 0.02


def test_the_page_pairs_machines():
    """Two designs on three machines, by hand."""
    held = np.array([True, True, True])
    alike = {key: np.full(3, 0.001 * (k + 1)) for k, key in enumerate(METRICS)}
    others = [0.001 * np.array([2.0, 0.5, 4.0]), np.full(3, 0.001), np.full(3, np.nan)]
    own = DesignStatistics(held, True, {}, alike)
    other = DesignStatistics(
        held & [True, False, True], True, {}, dict(zip(METRICS, others, strict=True))
    )
    ((motion, name, kept, path, impulse, rms),) = versus("circle", {OWN: own, "other": other})
    assert (motion, name, kept) == ("circle", "other", "100 %, 66.7 %")
    # The ratios are 0.5, 2 and 0.25; 2; nothing to compare with.
    assert path.startswith("2, 0.50")
    assert impulse.startswith("0, 2.00")
    assert rms.startswith("3, 0.00")
