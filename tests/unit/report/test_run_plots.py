"""Diagrams of a run, and pictures of searches and of many runs."""

import re

import numpy as np
import pytest
from random_runs import INPUTS, design

from hfc_design.controllers.hierarchical import drawn_tree as diagrams
from hfc_design.controllers.hierarchical import pictures
from hfc_design.pictures.files import image
from hfc_design.report import batch_plots, searches
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


@pytest.mark.parametrize("scores", [[0.0], [0.0, 5.0], [1e-3, 1e9]])
def test_pictures_of_odd_scores(scores):
    labels = ["1: $x^$ \x01 漢", "2: _"]
    groups = [np.array(scores), np.array(scores[:1])]
    runs = [[np.array([value]) for value in values] for values in groups]
    drawing = image(searches.convergence(labels, runs, [0, 1]), "svg").decode()
    assert "1: $x^$ ? ?<" in drawing
    figure = batch_plots.outcomes({"1: race $x": groups[0], "2": groups[1]}, "fitness")
    assert image(figure, "svg")
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()] == ["1", "2"]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["1: race $x", "2"]
    shown = [handle.get_color() for handle in legend.legend_handles]
    assert shown == ["#0072B2", "#D55E00"]


def test_a_band_is_made_of_the_quartiles_of_the_runs(tmp_path):
    random = np.random.default_rng(0)
    runs = random.random((9, 40)).cumsum(axis=1)
    axes = searches.convergence(["1"], [list(runs)], [0]).axes[0]
    low, median, high = np.percentile(runs, [25, 50, 75], axis=0)
    assert axes.lines[0].get_xdata().tolist() == list(range(1, 41))
    assert axes.lines[0].get_ydata() == pytest.approx(median)
    edges = axes.collections[0].get_paths()[0].vertices[1:41, 1]
    if axes.get_yscale() == "log":
        low = np.maximum(low, median.min())
    assert edges == pytest.approx(low) or edges == pytest.approx(high)


@pytest.mark.parametrize(
    "values",
    [
        [1e-5, 3.0],
        [1e9, 1.0],
    ],
)
def test_ratios_stand_inside_their_picture_with_ticks_apart(values):
    axes = batch_plots.ratios([f"quantity {k} [rad/s]" for k in range(len(values))], values).axes[0]
    low, high = axes.get_xlim()
    assert all(1.2 * low < value < high / 1.2 for value in values)
    ticks = axes.get_xticks()
    assert 2 <= len(ticks) <= 10
    assert 1.0 in ticks
    apart = np.diff(np.log(ticks)) / np.log(high / low)
    assert (apart > 0.06).all()
    assert axes.get_yticklabels()[0].get_text() == "quantity 0 [rad/s]"
