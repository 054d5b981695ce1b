"""The stable range as a picture, JK04 fig. 4."""

from collections.abc import Mapping
from itertools import cycle
from math import ceil

import numpy as np
from matplotlib.figure import Figure

from hfc_design.pictures.figure import OTHER, OWN, framed
from hfc_design.stability.stable_range import StableRange, k2_bound

MARKERS = "os^Dv*"
#: Height of a line of the legend [in].
LINE = 0.19


def stability_figure(
    found: StableRange, points: Mapping[str, tuple[float, float]] | None = None
) -> Figure:
    """The bound of K_2 against K_1 [unit/BLU], the range shaded.

    ``points`` are (K_1, K_2) of rule tables by their names.
    """
    top = 0.15 + LINE * ceil((3 + len(points or {})) / 2)
    figure = framed(3.4 + top, top)
    axes = figure.subplots()
    inside = np.linspace(0.0, found.k1, 201)[1:]
    beyond = np.linspace(found.k1, found.k1_printed, 51)
    bound = k2_bound(found.drive, inside)
    axes.fill_between(inside, bound, color=OWN, alpha=0.15, lw=0, label="stable range")
    axes.plot(inside, bound, color=OWN, lw=1.8)
    if found.k1 < found.k1_printed:
        axes.plot(beyond, k2_bound(found.drive, beyond), color=OWN, lw=1, ls=":", label="printed")
    axes.axvline(found.k1_linear, color=OTHER, lw=1.2, ls="--", label="linear limit")
    for marker, (name, (k1, k2)) in zip(cycle(MARKERS), (points or {}).items(), strict=False):
        axes.plot([k1], [k2], color="black", mfc="none", ls="", marker=marker, ms=6, label=name)
    axes.set_xlabel("$K_1$ [unit/BLU]")
    axes.set_ylabel("$K_2$ [unit/BLU]")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    figure.legend(fontsize=9, frameon=False, ncols=2, loc="upper center")
    return figure
