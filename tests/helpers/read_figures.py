"""Figures read back."""

from itertools import pairwise

import numpy as np


def lines_of(axes):
    """Label -> (2, points) of every line."""
    return {line.get_label(): np.array(line.get_data()) for line in axes.lines}


def read_apart(figure, axes):
    """The numbers that are seen, none on another."""
    figure.draw_without_rendering()
    low, high = axes.get_xlim()
    ticks = [*axes.xaxis.get_major_ticks(), *axes.xaxis.get_minor_ticks()]
    shown = [x for x in ticks if x.label1.get_text() and low <= x.get_loc() <= high]
    labels = [x.label1 for x in sorted(shown, key=lambda x: x.get_loc())]
    boxes = [label.get_window_extent() for label in labels]
    assert len(boxes) > 2
    assert all(one.x1 + 2.0 < other.x0 for one, other in pairwise(boxes))
    return [label.get_text() for label in labels]
