"""Pictures of terms: their tops, their inputs, names that stay apart."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from hfc_design.files.loop_setup import load_design
from hfc_design.pictures.column import in_column
from hfc_design.pictures.terms import Panel, terms
from hfc_design.report.designs import picture


@pytest.mark.parametrize("letters", [2, 12, 32])
@pytest.mark.parametrize("paper", [False, True])
def test_names_stay_apart_and_within_the_figure(letters, paper):
    centres = np.linspace(-1.0, 1.0, 11)
    curves = {chr(65 + k) * letters: (centres, own) for k, own in enumerate(np.eye(len(centres)))}
    figure = terms([Panel("error [1]", (-1.25, 1.25), curves)] * 2, "terms")
    figure.set_dpi(300.0)  # else letters are as wide as whole dots make them
    if paper:
        in_column(figure, 252 / 72.27)
    renderer = FigureCanvasAgg(figure).get_renderer()
    for axes in figure.axes:
        texts = [*axes.texts, *figure.texts]
        boxes = [text.get_window_extent(renderer) for text in texts]
        boxes.append(axes.get_window_extent(renderer))
        assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
        assert all(figure.bbox.x0 <= b.x0 and b.x1 <= figure.bbox.x1 for b in boxes)
        others = [axes.xaxis.label.get_window_extent(renderer) for axes in figure.axes]
        assert not any(a.overlaps(b) for a in boxes[:-2] for b in others)


DESIGNS = {
    "jee-koren-2004-flc": ("", ["error [BLU]", "change of error [BLU per sample]"]),
    "lin-gai-2009-fuzzy-sliding": ("x", ["error [mm]", "error rate [mm/s]"]),
    "lin-lee-1999-table-1": ("", ["input of a unit, scaled [1]"]),
    "huang-soc": ("", ["error, a set is 0.1 mm; its change in a sample, a set is 0.0333 mm"]),
}


@pytest.mark.parametrize(("name", "axis", "labels"), [(k, *v) for k, v in DESIGNS.items()])
def test_each_term_of_each_input_is_drawn_up_to_1(name, axis, labels):
    figure = picture(load_design(name), "terms", axis=axis)
    assert [axes.get_xlabel() for axes in figure.axes] == labels
    for axes in figure.axes:
        tops = [np.max(line.get_ydata()) for line in axes.lines]
        assert tops == pytest.approx([1.0] * len(axes.texts), abs=1e-12)
