"""A circular test: its numbers, its tables, the chart of a ball bar and a page for a customer."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from hfc_design.core.numbers import Floats, Json
from hfc_design.core.tables import Table, line, table, text
from hfc_design.motion.circularity import EITHER, NAMES, RADIUS, Cause, Turns
from hfc_design.plotting.curves import thinned
from hfc_design.plotting.figure import above, round_above, stroke
from hfc_design.plotting.files import Displayed

#: Points of a circle; width of a division of the chart, as a share of the radius.
AROUND, BAR = 360, 0.2
A4, WIDE = (8.27, 11.69), (10.0, 4.8)  # sizes of figures [in]
#: Beginning of a symbol -> what a limit calls it, and its meaning.
MEANT = {
    "G(b)": ("Gb", "bi-directional circular deviation"),
    "G": ("G", "circular deviation"),
    "F": ("F", "radial deviation"),
    "D": ("D", "mean bi-directional radial deviation"),
}
#: Beginning of a cause -> its detail if its value is positive, and if it is negative.
DETAILS = {
    RADIUS: ("too large", "too small"),
    "scale": ("X {ppm:.3g} µm/m longer than Y", "Y {ppm:.3g} µm/m longer than X"),
    "squareness": ("angle {ppm:.3g} µm/m too small", "angle {ppm:.3g} µm/m too large"),
    "servo": ("X lags {ms:.3g} ms more than Y", "Y lags {ms:.3g} ms more than X"),
    "backlash": ("", "over-compensated"),
    "reversal": ("{width:.1f} deg wide, outwards", "{width:.1f} deg wide, inwards"),
}
#: Notes on what a test cannot show.
ONE = "One direction alone: squareness and servo mismatch cannot be told apart; no G(b), no D."
FITTED = "No reference in the log: {} cannot be told, as the nominal circle is fitted."


class CircleTest(NamedTuple):
    """Result of a circular test; lengths in mm."""

    turns: Turns
    radius: float
    feed: float | None  # [mm/min]
    deviations: dict[str, float]  # of ISO 230-4, by symbol
    causes: list[Cause]
    limits: Mapping[str, float]  # of "G", "Gb", "F", "D"
    about: Sequence[str]  # lines for the page
    notes: list[str]  # sentences on what the test cannot show

    def __repr__(self) -> str:
        return line("CircleTest", self.deviations | {"largest": self.causes[0].name})

    def _repr_html_(self) -> str:
        return table("circular test [mm]", self.deviations | {"largest": self.causes[0].name})

    @property
    def passes(self) -> bool | None:
        """Whether no deviation exceeds its limit; None: there are no limits."""
        each = ((abs(x), self.limits.get(meant(key)[0])) for key, x in self.deviations.items())
        verdicts = [size <= limit for size, limit in each if limit is not None]
        return all(verdicts) if verdicts else None

    def numbers(self) -> Json:
        """Return the output of ``hfc circle --json``."""
        total = sum(one.size for one in self.causes)
        named = ((one, self._detail(one)) for one in self.causes)
        causes = {
            x.name: {"size_mm": x.size, "share": x.size / total, "detail": y} for x, y in named
        }
        judged = {"limits_mm": dict(self.limits), "passes": self.passes, "notes": self.notes}
        test = {"radius_mm": self.radius, "feed_mm_min": self.feed, "about": [*self.about]}
        largest = {"largest": self.causes[0].name, "causes": causes}
        return {**test, "deviations_mm": self.deviations, **largest, **judged}

    def tables(self) -> list[Table]:
        """Return tables of the deviations and of the causes, and the notes."""
        rows, total = [], sum(one.size for one in self.causes)
        for symbol, value in self.deviations.items():
            key, meaning = meant(symbol)
            limit = self.limits.get(key)
            judged = ["pass" if abs(value) <= limit else "fail"] if limit else [""]
            allowed = f"{1e3 * limit:g}" if limit else ""
            rows.append([meaning, symbol, f"{1e3 * value:.1f}", allowed, *judged])
        sized = [
            [x.name, f"{1e3 * x.size:.1f}", f"{100 * x.size / total:.0f}", self._detail(x)]
            for x in self.causes
        ]
        feed = f", feed {self.feed:.4g} mm/min" if self.feed else ""
        title = f"radius {self.radius:.6g} mm{feed}"
        head = ["deviation (ISO 230-4)", "symbol", "value [µm]", "limit [µm]", ""]
        of_causes = Table("", ["cause", "size [µm]", "share [%]", "detail"], sized)
        return [Table("", head, rows, title=title), of_causes, text(*self.notes)]

    def _detail(self, cause: Cause) -> str:
        """Return the sign and the physical quantity of a cause in words."""
        known = {"ppm": 1e6 * abs(cause.value) / self.radius, "width": cause.width}
        if self.feed:
            known["ms"] = 6e4 * abs(cause.value) / self.feed
        texts = next((DETAILS[x] for x in DETAILS if cause.name.startswith(x)), ("", ""))
        chosen = texts[cause.value < 0]
        unknown = cause.name == EITHER or ("{ms" in chosen and not self.feed)
        return "" if unknown else chosen.format(**known)

    def figure(self, page: bool = False) -> Figure:
        """Draw the directions as a ball bar does, with the tables; ``page``: A4 with the texts."""
        figure = Displayed(figsize=A4 if page else WIDE)
        place = (0.22, 0.46, 0.56, 0.3963) if page else (0.04, 0.12, 0.4, 0.76)
        axes = figure.add_axes(place, projection="polar")
        curves = []
        for k, (side, points) in enumerate(self.turns.items()):
            label = f"{NAMES[side]}, {'counter-' * (side > 0)}clockwise"
            off = np.hypot(*points) - self.radius
            curves.append(
                (np.arctan2(*points[::-1]), off, {**stroke(k), "lw": 1.0, "label": label})
            )
        division = ball_bar(axes, curves)
        deviations, causes, _ = self.tables()
        middle, low, high = (0.5, 0.43, 0.905) if page else (0.24, 0.02, 1.0)
        above(figure, axes, 8, 2, bbox_to_anchor=(middle, high))
        scale = f"{deviations.title}; one ring: {1e3 * division:g} µm, outwards is positive"
        figure.text(middle, low, scale, ha="center", fontsize=8)
        left, wide, tops = (0.1, 0.8, (0.415, 0.26)) if page else (0.5, 0.49, (0.96, 0.5))
        _write(figure, deviations, (left, 0.0, wide, tops[0]), (0.45, 0.14, 0.16, 0.15, 0.1))
        _write(figure, causes, (left, 0.0, wide, tops[1]), (0.35, 0.14, 0.15, 0.36))
        if page:
            verdict = {None: "", True: ": within all limits", False: ": not within all limits"}
            title = f"Circular test{verdict[self.passes]}"
            figure.text(0.1, 0.95, title, fontsize=15, weight="bold")
            about, notes = "\n".join(self.about), "\n".join(self.notes)
            figure.text(0.1, 0.94, about, fontsize=9, va="top", parse_math=False)
            figure.text(0.1, 0.03, notes, fontsize=7.5, color="0.3")
        return figure


def meant(symbol: str) -> tuple[str, str]:
    """Return what a limit calls the deviation with a ``symbol``, and its meaning."""
    return next(MEANT[begin] for begin in MEANT if symbol.startswith(begin))


def ball_bar(
    axes: Any, curves: Iterable[tuple[Floats, Floats, dict[str, Any]]], division: float = 0.0
) -> float:
    """Draw radial deviations around a circle in polar ``axes``; return the division of the rings.

    ``curves`` are angle [rad], deviation and style of each; ``division`` is chosen if it is 0.
    """
    known = [*curves]
    division = division or round_above(max(np.abs(off).max() for _, off, _ in known) / 2)
    axes.plot(np.linspace(0.0, 2 * np.pi, AROUND), np.ones(AROUND), color="black", lw=0.9)
    for angle, off, style in known:
        axes.plot(*thinned(np.unwrap(angle), 1.0 + BAR * off / division), **style)
    axes.set_rticks([1.0 + BAR * k for k in (-2, -1, 1, 2)], [""] * 4)
    axes.set_rlim(0.0, 1.0 + 2.4 * BAR)
    axes.tick_params(labelsize=8)
    axes.grid(color="0.8")
    return division


def _write(figure: Figure, listing: Table, place: Any, widths: Sequence[float]) -> None:
    """Write a table at the top of a ``place``, with its columns as shares of the width."""
    axes = figure.add_axes(place)
    axes.axis("off")
    shape: Any = {"loc": "upper left", "cellLoc": "left", "edges": "horizontal"}
    drawn = axes.table([[*row] for row in (listing.head, *listing.rows)], colWidths=widths, **shape)
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(8)
    for (row, _), cell in drawn.get_celld().items():
        cell.PAD = 0.01
        cell.set(linewidth=0.4, edgecolor="0.6")
        cell.set_text_props(weight="normal" if row else "bold")
