"""Pictures of terms: their tops, their inputs, names that stay apart."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from hfc_design.pictures.column import in_column
from hfc_design.pictures.terms import Panel, terms


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
