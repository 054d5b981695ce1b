"""How the metrics of a design spread over machines that differ."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hfc_design.core.shapes import Floats
from hfc_design.pictures.figure import OTHER, OWN, WIDTH
from hfc_design.simulation.monte_carlo import QUANTILES, Robustness

COLUMNS = 2
PANEL = 1.45  # height [in]
#: Margins round the panels [in].
LEFT, RIGHT, TOP, BOTTOM = 0.65, 0.2, 0.75, 0.6


def distributions(found: Robustness, title: str) -> Figure:
    """Of each metric, the share of stable machines up to a value, and the nominal one's value.

    The band reaches from the 5 % to the 95 % quantile. A metric that is the same on every machine
    is left out.
    """
    drawn = [key for key in found.values if np.unique(found.spread_of(key)).size > 1]
    rows = max(-(-len(drawn) // COLUMNS), 1)
    height = PANEL * rows + TOP + BOTTOM
    figure = Figure(figsize=(WIDTH, height))
    figure.subplots_adjust(
        left=LEFT / WIDTH, right=1 - RIGHT / WIDTH, bottom=BOTTOM / height, top=1 - TOP / height
    )
    panels = figure.subplots(
        rows, COLUMNS, sharey=True, squeeze=False, gridspec_kw={"hspace": 0.75, "wspace": 0.12}
    )
    for axes, key in zip(panels.flat, drawn, strict=False):
        values = found.spread_of(key)
        only = "" if len(values) == found.stable.sum() else f", {len(values)} machines"
        _draw(axes, key + only, values, found.nominal[key])
    for axes in panels.flat[len(drawn) :]:
        axes.set_visible(False)
    for axes in panels[:, 0]:
        axes.set_ylabel("share [1]")
    share = 100 * found.stable.mean()
    figure.suptitle(
        f"{title}\n{len(found.stable)} machines, parameters ±{100 * found.spread:g} %, "
        f"{share:.4g} % stable",
        fontsize=11,
        y=1 - 0.08 / height,
    )
    if drawn:
        handles = panels.flat[0].get_legend_handles_labels()
        figure.legend(*handles, fontsize=9, frameon=False, ncols=3, loc="lower center")
    return figure


def _draw(axes: Axes, title: str, values: Floats, nominal: float) -> None:
    low, *_, high = np.quantile(values, QUANTILES)
    axes.axvspan(low, high, color=OWN, alpha=0.12, lw=0, label="5 % to 95 %")
    axes.ecdf(values, color=OWN, lw=1.6, label="machines")
    if np.isfinite(nominal):
        axes.axvline(nominal, color=OTHER, lw=1.2, ls="--", label="nominal")
    axes.set_title(title, fontsize=9)
    axes.tick_params(labelsize=8)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=4))
    axes.set_yticks([0.0, 0.5, 1.0])
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
