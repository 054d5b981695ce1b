"""Margins of simulated loops, as ``hfc stability``, the pages and ``usable`` show them."""

from collections.abc import Mapping, Sequence
from math import inf
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Json
from hfc_design.core.shown import line, table
from hfc_design.stability.margins import ASKED, Margins, OpenLoop

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # takes longer than all the rest

#: Shares of the machines that a band is between.
BAND = (0.05, 0.95)
#: Columns of a table: title, number, unit in the title.
COLUMNS = {
    "gain_down": "gain\ndown",
    "gain_up": "gain\nup",
    "phase_deg": "phase\n[deg]",
    "delay_samples": "delay\n[samples]",
    "sensitivity": "\nMs",
    "sensitivity_hz": "at\n[Hz]",
    "disk": "\ndisk",
    "crossover_hz": "crossover\n[Hz]",
    "bandwidth_hz": "band\n[Hz]",
    "compliance": "compliance\n[{}]",
}
ABOUT = (
    "Each loop of the simulation opened at its command, linearised in steady motion at a speed: "
    "with sensors, observer, delay and friction as they are there, without converter steps and "
    "limits. Gain: factors on it up to which it is stable; phase, delay: what more of a lag it "
    "bears; Ms: largest |1 / (1 + L)|; disk: of gain and phase together; band: of the closed loop, "
    "-3 dB; compliance: largest |position / load|; -: no change of that kind makes it oscillate"
)
BANDS = "below: between 5 and 95 % of {} other machines"


class At(NamedTuple):
    """The loop of one axis at an operating point."""

    point: str
    axis: str  # "" where there is one
    why: str  # there are no margins; "" where there are
    numbers: dict[str, float | bool | None]  # of the nominal machine; None: without an end
    band: dict[str, tuple[float | None, float | None]]  # over other machines
    loop: OpenLoop | None  # of the nominal machine

    @property
    def name(self) -> str:
        """What tables call it."""
        return " ".join(filter(None, (self.axis, self.point)))


class LoopMargins(NamedTuple):
    """Margins of a design's loops at the operating points of a scenario."""

    rows: Sequence[At]
    sample_time: float  # [s]
    plant: str  # name of the machine
    units: str  # of its compliance
    machines: int  # beside the nominal one

    def __repr__(self) -> str:
        return line("LoopMargins", {"stable": self.stable, **self._worst()})

    def _repr_html_(self) -> str:
        return table("worst margins of the loop, opened at the command", self._worst())

    def _worst(self) -> dict[str, float | None]:
        return {name: value for name, (value, _) in self.worst.items()}

    @property
    def stable(self) -> bool | None:
        """Whether the loops of the nominal machine are, at rest and at speed; None: there are none.

        Between the two friction that falls with the speed may push, which motions there show.
        """
        each: dict[str, list[bool]] = {}
        for row in self.rows:
            if not row.why:
                each.setdefault(row.axis, []).append(bool(row.numbers["stable"]))
        return all(one[0] and one[-1] for one in each.values()) if each else None

    @property
    def crossover(self) -> float | None:
        """The highest frequency at which a loop of the nominal machine has the magnitude 1 [Hz]."""
        each = [row.numbers["crossover_hz"] for row in self.rows if not row.why]
        return max((x for x in each if x), default=None)

    @property
    def worst(self) -> dict[str, tuple[float | None, str]]:
        """Of each of ``ASKED`` the worst of the nominal machine, and where; None: without an end.

        A loop that is not stable has no margin.
        """
        found = {}
        for name, (key, more, _) in ASKED.items():
            each = [(_value(row, key, more), row.name) for row in self.rows if not row.why]
            if each:
                value, where = (max if more else min)(each, key=lambda one: one[0])
                found[name] = (value if np.isfinite(value) else None), where
        return found

    def broken(self, asked: Mapping[str, float]) -> list[str]:
        """What the loop has and where, of that of ``asked`` that it does not keep."""
        found = []
        for name, limit in asked.items():
            value, where = self.worst.get(name, (None, ""))
            more, told = ASKED[name][1], "at least "
            if value is None and (not more or not where):
                continue
            if value is None or (value > limit if more else value < limit):
                own = f"{name} {value:.3g}" if value else "the loop is unstable"
                at = where if where == "at rest" else f"at {where}"
                found.append(f"{own} {at}, allowed {'' if more else told}{limit:g}")
        return found

    def numbers(self) -> Json:
        """What ``hfc stability --json`` prints."""
        rows = [
            {"point": one.point, "axis": one.axis, **({"why": one.why} if one.why else {})}
            | one.numbers
            | {"band": {key: [*ends] for key, ends in one.band.items()}}
            for one in self.rows
        ]
        worst = {name: {"value": value, "at": at} for name, (value, at) in self.worst.items()}
        told = {"sample_time": self.sample_time, "plant": self.plant, "machines": self.machines}
        return {**told, "stable": self.stable, "worst": worst, "points": rows}

    def figure(self) -> "Figure":
        """Magnitude and phase of the open loops by the frequency [Hz], and their sensitivity."""
        from matplotlib.ticker import NullFormatter

        from hfc_design.pictures.figure import OTHER, OWN, framed, gridded

        figure = framed(6.4, top=0.3)
        parts = size, phase, peak = figure.subplots(3, sharex=True)
        angles = np.pi * np.geomspace(1e-4, 1.0, 1500)
        hertz = angles / (2.0 * np.pi * self.sample_time)
        drawn = [row for row in self.rows if row.loop is not None]
        for row, color in zip(drawn, (OWN, OTHER, "0.4", "0.7") * len(drawn), strict=False):
            assert row.loop is not None
            response = row.loop.reduced().transfer(angles)
            size.loglog(hertz, np.abs(response), color=color, lw=1.6, label=row.name)
            phase.semilogx(hertz, lag(response), color=color, lw=1.6)
            peak.semilogx(hertz, np.abs(1.0 / (1.0 + response)), color=color, lw=1.6)
        size.axhline(1.0, color="0.3", lw=0.9)
        phase.axhline(-180.0, color="0.3", lw=0.9)
        gridded(size, y="magnitude [1]")
        gridded(phase, y="phase [deg]")
        gridded(peak, "frequency [Hz]", "sensitivity [1]")
        if len(drawn) > 1:
            size.legend(fontsize=9, frameon=False, ncols=2)
        for part in parts:
            part.yaxis.set_label_coords(-0.125, 0.5)
            for axis in (part.xaxis, part.yaxis):  # powers of ten would be in small letters
                axis.set_major_formatter("{x:g}")
                axis.set_minor_formatter(NullFormatter())
        return figure

    def show(self) -> None:
        """Print the margins, a row for each operating point."""
        from hfc_design.core.console import plain_table, room, show_whole  # which imports rich

        heads, rows = self.cells()
        shown = plain_table(caption=self.about, caption_justify="left")
        for k, head in enumerate(heads):
            shown.add_column(head, justify="right" if k else "left", no_wrap=True)
        for row in rows:
            shown.add_row(*row)
        show_whole(shown)
        for one in self.rows:
            if one.why:
                print(fill(f"{one.name}: {one.why}", room()))

    @property
    def about(self) -> str:
        """What the margins are of."""
        band = f"; {BANDS.format(self.machines)}" if self.machines else ""
        return f"On the plant {self.plant}. {ABOUT}{band}"

    def cells(self) -> tuple[list[str], list[list[str]]]:
        """Heads and rows of a table, numbers of the nominal machine above the band of others."""
        heads = ["at", "stable", *(head.format(self.units) for head in COLUMNS.values())]
        rows = []
        for one in self.rows:
            if one.why:
                rows.append([one.name, *["-"] * (len(heads) - 1)])
                continue
            stable = bool(one.numbers["stable"])
            own = [_told(one.numbers[key]) if stable else "-" for key in COLUMNS]
            ends = [one.band.get(key) for key in COLUMNS]
            told = ["" if end is None else "\n" + "..".join(map(_told, end)) for end in ends]
            cells = [text + band for text, band in zip(own, told, strict=True)]
            rows.append([one.name, "yes" if stable else "no", *cells])
        return heads, rows


def numbers(found: Margins, every: float, compliance: tuple[float, float]) -> Json:
    """Margins as plain data, frequencies in Hz for samples of ``every`` [s]; None: no end."""

    def hertz(angle: float | None) -> float | None:
        return None if angle is None else angle / (2.0 * np.pi * every)

    return {
        "stable": found.stable,
        "gain_up": found.gain_up,
        "gain_down": found.gain_down,
        "phase_deg": found.phase,
        "delay_samples": found.delay,
        "delay_ms": None if found.delay is None else 1e3 * every * found.delay,
        "sensitivity": found.sensitivity,
        "sensitivity_hz": hertz(found.peak),
        "disk": found.disk,
        "crossover_hz": hertz(found.crossover),
        "bandwidth_hz": hertz(found.bandwidth),
        "compliance": compliance[0],
        "compliance_static": compliance[1],
        "slowest_pole": float(abs(found.poles[0])) if found.poles else 0.0,
    }


def band(others: Sequence[Json]) -> dict[str, tuple[float | None, float | None]]:
    """Between what the numbers of others are: the share ``BAND`` of those that are stable."""
    found = {}
    for key in others[0] if others else ():
        if key != "stable":
            each = [inf if one[key] is None else one[key] for one in others if one["stable"]]
            if each:
                ends = np.quantile(each, BAND, method="nearest")
                low, high = (float(x) if np.isfinite(x) else None for x in ends)
                found[key] = low, high
    return found


def _value(row: At, key: str, more: bool) -> float:
    if not row.numbers["stable"]:
        return inf if more else 0.0
    value = row.numbers[key]
    return inf if value is None else float(value)


def _told(value: float | bool | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def lag(response: Floats) -> Floats:
    """Phase [deg] without jumps, such that at the lowest frequency it lies between -315 and 45.

    There it is a multiple of -90 for every integrator: with three of them -270, which else would
    be drawn as +90 and the crossing of the magnitude a whole turn above the -180 that it is near.
    """
    turned = np.degrees(np.unwrap(np.angle(response)))
    return np.asarray(turned - 360.0 * np.ceil((turned[0] - 45.0) / 360.0))
