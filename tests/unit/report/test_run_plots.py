"""Diagrams of a run, and the picture of its search."""

import re

import numpy as np
import pytest
from random_runs import INPUTS, design

from hfc_design.controllers.hierarchical import drawn_tree as diagrams
from hfc_design.controllers.hierarchical import pictures
from hfc_design.pictures.files import image
from hfc_design.report import searches
from hfc_design.search.loop import History
from plants import C_AXIS


@pytest.mark.parametrize(("inputs", "tree"), [(2, 0), (6, 0), (6, 944)])
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


def test_history_of_one_generation_where_everything_diverged():
    history = History(np.array([np.nan]), np.array([np.nan]), np.array([30]), np.array([3]))
    assert image(searches.history(history, "merit"), "svg")


@pytest.mark.parametrize(
    ("best", "scale"),
    [
        ([1.0, 10.0, 1e4], "log"),
        ([np.nan, 10.0, 1e4], "log"),
        ([-1e4, -10.0, 1e4], "linear"),
        ([np.nan, np.nan, np.nan], "linear"),
    ],
)
def test_only_what_is_above_zero_is_drawn_by_its_logarithm(best, scale):
    nothing = np.full(3, np.nan)
    history = History(np.array(best), nothing, np.array([9, 9, 9]), np.array([1, 1, 1]))
    scores, _ = searches.history(history, "loss $x^$ / (1 + 300 stick share)").axes
    assert scores.get_yscale() == scale
    assert scores.get_title() == "loss $x^$ / (1 + 300 stick share)"
