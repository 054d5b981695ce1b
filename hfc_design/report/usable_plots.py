"""What many machines do in every motion, as a picture: of ``hfc score --spread --plot``."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hfc_design.pictures.figure import OTHER, OWN, drawable, framed, gridded, plain
from hfc_design.pictures.numbers import readable
from hfc_design.simulation.in_use import TITLES, Usable

#: Share of the machines that a panel shows: a few that run away would make the others a line.
SHOWN = 0.99


def distributions(found: Usable, title: str) -> Figure:
    """A row for each motion: the share of the machines up to a value of each measure.

    Machines that do not pass are among them. The nominal one is a dashed line.
    """
    rows, columns = len(found.motions), len(found.units)
    share = f"{100 * found.good.mean():.4g} % pass"
    machines = f"{len(found.good)} machines within ±{100 * found.spread:g} %: {share}"
    heading = [*filter(None, [title]), machines, "share of them up to a value"]
    top = 0.5 + 0.18 * len(heading)
    height = 1.15 * rows + top + 0.65
    figure = framed(height, top=top, left=0.8, right=0.15, bottom=0.65)
    shape = {"hspace": 0.75, "wspace": 0.15}
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False, gridspec_kw=shape)
    for row, motion in zip(grid, found.motions, strict=True):
        for axes, (name, own) in zip(row, found.units.items(), strict=True):
            values = motion.told[name][np.isfinite(motion.told[name])]
            most = float(np.quantile(values, SHOWN)) if len(values) else 0.0
            factor, unit = readable(own, most)
            if len(values):
                axes.ecdf(drawable(factor * values), color=OWN, lw=1.6, label="machines")
            if np.isfinite(nominal := motion.nominal[name]):
                style = {"color": OTHER, "lw": 1.2, "ls": "--", "label": "nominal"}
                axes.axvline(float(drawable(factor * nominal)), **style)
                most = max(most, nominal)
            gridded(axes)
            axes.set_xlim(0.0, float(drawable(1.05 * factor * most)) or 1.0)
            axes.xaxis.set_major_locator(MaxNLocator(nbins=4))
            axes.set_yticks([0.0, 0.5, 1.0])
            axes.tick_params(labelsize=7)
            axes.set_title(f"[{unit}]", fontsize=8, loc="right")
        row[0].set_ylabel(
            f"{plain(motion.name, 12)}\n{100 * motion.good.mean():.3g} % pass", fontsize=8
        )
    for axes, name in zip(grid[0], found.units, strict=True):
        called = TITLES.get(name, name.replace("_", " "))
        axes.set_title(f"{called}\n{axes.get_title('right')}", fontsize=8, loc="right")
    figure.suptitle("\n".join(heading), fontsize=10, y=1 - 0.08 / height)
    handles = grid[0, 0].get_legend_handles_labels()
    figure.legend(*handles, fontsize=9, frameon=False, ncols=2, loc="lower center")
    return figure
