"""The kept designs of contours, on paths and machines that no search has seen."""

from pathlib import Path

import pytest

import hfc_design.api as hfc
from experiments.designed_contours.table_page import METRICS

FOLDER = Path(__file__).parents[2] / "experiments" / "designed_contours"
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
