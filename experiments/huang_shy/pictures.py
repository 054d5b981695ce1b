"""Figures of the page of Huang & Shy, of the runs of its batch; see ``page``."""

from matplotlib.figure import Figure

from experiments.huang_shy.tables import of_laps
from experiments.shared import COLORS, Batch, curves
from hfc_design.plotting.figure import framed

ERROR = "path error [mm]"


def circle(batch: Batch) -> Figure:
    """Figs. 2 and 4: circle of 60 mm."""
    return _path_errors(batch, (("PID", "cross-coupling"), ("SOC", "neural")))


def small_circle(batch: Batch) -> Figure:
    """Figs. 9 and 10: circle of 25 mm."""
    return _path_errors(batch, (("SOC goes on", "neural goes on"),), "25 mm, ")


def milling(batch: Batch) -> Figure:
    """Fig. 11: circle of 30 mm under a cutting force."""
    return _path_errors(batch, (("neural goes on",),), "milling, ")


def _path_errors(batch: Batch, groups: tuple[tuple[str, ...], ...], head: str = "") -> Figure:
    found = {name: batch.motion(head + name) for group in groups for name in group}
    panels = {
        f"{ERROR}{' ' * k}": {name: found[name].contour.error for name in group}
        for k, group in enumerate(groups)
    }
    return curves(next(iter(found.values())).time, panels)


def sine(batch: Batch) -> Figure:
    """Fig. 3: a sine from zero rules."""
    found = batch.motion("sine, SOC")
    return curves(found.time, {"error [mm]": {"SOC": found.axes[0].motion.error}})


def axes(batch: Batch) -> Figure:
    """Figs. 5 to 8: tracking errors of both axes on the circle of 60 mm."""
    found = {name: batch.motion(name) for name in ("SOC", "neural")}
    panels = {
        f"error of {axis} [mm]": {name: own.axes[k].motion.error for name, own in found.items()}
        for k, axis in enumerate("XY")
    }
    return curves(found["SOC"].time, panels)


def laps(batch: Batch) -> Figure:
    """Path error and impulse over eight laps."""
    figure = framed(3.6, top=0.35)
    grid = figure.subplots(2, 1, sharex=True)
    for label, color in zip(("SOC", "neural"), COLORS, strict=False):
        own = of_laps(batch, f"laps, {label}")
        minutes = [0.75 * (k + 1) for k in range(len(own))]
        for panel, peaks in zip(grid, zip(*own, strict=True), strict=True):
            panel.plot(minutes, peaks, "o-", color=color, ms=4, lw=1.2, label=label)
    for panel, label in zip(grid, ("path error [mm]", "impulse [mm]"), strict=True):
        panel.set_ylabel(label)
        panel.set_ylim(0.0, 1.1 * panel.dataLim.y1)
        panel.grid(color="0.9")
    grid[-1].set_xlabel("end of a lap [min]")
    figure.legend(
        *grid[0].get_legend_handles_labels(), fontsize=9, frameon=False, ncols=2, loc="upper center"
    )
    return figure
