"""What ``hfc stability`` says: the range as plain data, a table and a picture (JK04 fig. 4)."""

from collections.abc import Iterable, Mapping
from itertools import cycle
from math import ceil
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from rich.table import Table

from hfc_design.core.console import show_whole
from hfc_design.core.numbers import Json, Parameters
from hfc_design.core.records import UserError
from hfc_design.core.shown import line, table
from hfc_design.stability.loop_report import LoopMargins
from hfc_design.stability.stable_range import StableRange

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # takes longer than all the rest

    from plants import Drive  # which imports JAX

#: K_2 bounds are told at these shares of the largest K_1.
SHARES = (0.1, 0.3, 0.5, 0.7, 0.9)
#: (K_1, K_2) of rule tables [unit/BLU], by how they were found.
Points = Mapping[str, tuple[float, float]]
MARKERS = "os^Dv*"
#: A K_2 beyond so many times the range's is left out of the picture: there it has no limit.
BEYOND = 4.0
#: What inside and outside mean.
WITHOUT = (
    "the drive is taken without friction; what is outside may still settle in one motion, which "
    "hfc score simulates"
)
#: Height of a line of the legend [in].
LINE = 0.19


class StableGains(NamedTuple):
    """Gains that keep a feed drive stable, and those of rule tables beside them [unit/BLU]."""

    range: StableRange
    points: Points  # of the design's tables; none without a design
    drive: Mapping[str, float]  # that it is about, as the arguments of ``stable_range``
    loop: LoopMargins | None = None  # of the design, on its own scenario

    def __repr__(self) -> str:
        inside = {name: self.range.contains(*point) for name, point in self.points.items()}
        told = {"k1_bound": self.range.k1_bound, "k1_linear": self.range.k1_linear}
        return line("StableGains", {**told, **inside})

    def _repr_html_(self) -> str:
        return table("stable range, JK04 section 3; gains in unit/BLU", rows(self))

    def numbers(self) -> Json:
        """What ``hfc stability --json`` prints."""
        found = self.range
        k1 = found.k1_bound * np.array(SHARES)
        k2 = zip(k1.tolist(), found.k2(k1).tolist(), strict=True)
        points = {
            name: {"k1": x, "k2": y, "inside": bool(found.contains(x, y))}
            for name, (x, y) in self.points.items()
        }
        return {
            "drive": dict(self.drive),
            **found._asdict(),
            "k2_bounds": [{"k1": x, "k2": y} for x, y in k2],
            "points": points,
            **({"loop": self.loop.numbers()} if self.loop else {}),
        }

    def figure(self) -> "Figure":
        """The bound of K_2 against K_1 (JK04 fig. 4)."""
        return stability_figure(self.range, self.points)

    def show(self) -> None:
        """Print the numbers as a table."""
        shown = Table(caption=f"gains in unit/BLU; {WITHOUT}", caption_justify="left")
        shown.add_column("stable range, JK04 section 3", no_wrap=True)
        shown.add_column("value", justify="right")
        for name, value in rows(self).items():
            shown.add_row(name, value)
        show_whole(shown)
        if self.loop:
            self.loop.show()


def drive_of(
    told: str, axes: "Iterable[tuple[Drive, Parameters]]", every: float, given: Mapping[str, float]
) -> dict[str, float]:
    """Arguments of ``stable_range``: what is ``given``, else the design's own.

    ``told`` says what the design is for. Of its ``axes`` that with the largest gain counts;
    ``every`` is the sample time [s].

    Raises:
        UserError: the plant is no feed drive, and gain or time constant are not given.
    """
    linear = [drive.linear(parameters) for drive, parameters in axes if drive.linear]
    own = dict(zip(("gain", "time_constant"), max(linear), strict=True)) if linear else {}
    found = {"sample_time": every, **own, **given}
    if not {"gain", "time_constant"} <= found.keys():
        raise UserError(f"{told}, no feed drive: give --gain and --time-constant of its drive")
    return found


def rows(gains: StableGains) -> dict[str, str]:
    """The numbers as people read them."""
    found, data = gains.range, gains.numbers()
    drive = gains.drive
    values = {
        "drive: K [(BLU/s)/unit]": drive["gain"],
        "drive: tau [s]": drive["time_constant"],
        "sample time T [s]": drive["sample_time"],
        "K_0 [BLU/unit]": found.k0,
        "a": found.a,
        "b": found.b,
        "K_1 below, the range": found.k1_bound,
        "K_1 below, eq. 21 as printed": found.k1_printed,
        "K_1 below, linear loop": found.k1_linear,
        "K_1 below, eq. 21, sign corrected": found.k1_theorem,
        **{f"K_2 below, at K_1 = {p['k1']:.5g}": p["k2"] for p in data["k2_bounds"]},
    }
    told = {name: f"{value:.6g}" for name, value in values.items()}
    for name, point in data["points"].items():
        where = "inside" if point["inside"] else "outside"
        told[f"{name}: K_1, K_2"] = f"{point['k1']:.4g}, {point['k2']:.4g} {where}"
    return told


def stability_figure(found: StableRange, points: Points) -> "Figure":
    """The bound of K_2 against K_1 [unit/BLU], the range shaded, ``points`` by their names."""
    from hfc_design.pictures.figure import OTHER, OWN, framed

    top = 0.15 + LINE * ceil((3 + len(points)) / 2)
    figure = framed(3.4 + top, top)
    axes = figure.subplots()
    inside = np.linspace(0.0, found.k1_bound, 201)[1:]
    beyond = np.linspace(found.k1_bound, found.k1_printed, 51)
    bound = found.k2_printed(inside)
    axes.fill_between(inside, bound, color=OWN, alpha=0.15, lw=0, label="stable range")
    axes.plot(inside, bound, color=OWN, lw=1.8)
    if found.k1_bound < found.k1_printed:
        axes.plot(beyond, found.k2_printed(beyond), color=OWN, lw=1, ls=":", label="printed")
    axes.axvline(found.k1_linear, color=OTHER, lw=1.2, ls="--", label="linear limit")
    for marker, (name, (k1, k2)) in zip(cycle(MARKERS), points.items(), strict=False):
        axes.plot([k1], [k2], color="black", mfc="none", ls="", marker=marker, ms=6, label=name)
    axes.set(xlabel="$K_1$ [unit/BLU]", ylabel="$K_2$ [unit/BLU]", axisbelow=True)
    highest, end = max(k2 for _, k2 in points.values()) if points else 0.0, BEYOND * bound[0]
    axes.set(xlim=(0.0, None), ylim=(0.0, end if highest > end else None))
    axes.grid(color="0.9")
    figure.legend(fontsize=9, frameon=False, ncols=2, loc="upper center")
    return figure
