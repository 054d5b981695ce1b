"""Diagrams of a run, and pictures of searches and of many runs."""

import re

import numpy as np
import pytest
from random_runs import INPUTS, design

from hfc_design.controllers.hierarchical import drawn_tree as diagrams
from hfc_design.controllers.hierarchical import pictures
from hfc_design.plotting.files import image
from hfc_design.report import searches
from plants import C_AXIS


@pytest.mark.parametrize(("inputs", "tree"), [(2, 0), (6, 944)])
def test_diagrams_show_every_unit_and_input(inputs, tree):
    found = design(inputs, tree)
    drawing = image(diagrams.drawn_tree(found.controller, C_AXIS), "svg").decode()
    words = {word for name in INPUTS[:inputs] for word in name.split("_")}
    texts = set(re.findall(r">([^<>]+)</t", drawing))
    assert words <= {word for text in texts for word in text.split()}
    assert {f"unit {unit.id}" for unit in found.controller.units} <= texts
    for k, unit in enumerate(found.controller.units):
        drawing = image(pictures.table(found.controller, k), "svg").decode()
        assert f"unit {unit.id}<" in drawing
        assert f"row: {diagrams.readable(unit.row_input)}<" in drawing


def test_a_band_is_made_of_the_quartiles_of_the_runs(tmp_path):
    random = np.random.default_rng(0)
    runs = random.random((9, 40)).cumsum(axis=1)
    axes = searches.convergence({"1": list(runs)}).axes[0]
    low, median, high = np.percentile(runs, [25, 50, 75], axis=0)
    assert axes.lines[0].get_xdata().tolist() == list(range(1, 41))
    assert axes.lines[0].get_ydata() == pytest.approx(median)
    edges = axes.collections[0].get_paths()[0].vertices[1:41, 1]
    if axes.get_yscale() == "log":
        low = np.maximum(low, median.min())
    assert edges == pytest.approx(low) or edges == pytest.approx(high)
