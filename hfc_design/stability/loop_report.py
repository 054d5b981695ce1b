"""Margins of linear loops, as ``hfc stability`` and the page show them."""

from collections.abc import Mapping
from math import floor, log10
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from rich.table import Table

from hfc_design.core.console import show_whole
from hfc_design.core.numbers import Floats, Json
from hfc_design.core.shown import line, table
from hfc_design.stability.margins import Margins, OpenLoop, margins

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # takes longer than all the rest

#: Loops by the names of their axes, "" where there is one.
Loops = Mapping[str, OpenLoop]
NONE = "none"
ABOUT = (
    "Near the speed at which friction slides, without sensors, rest and limits: what an observer, "
    "a filter or a converter lags has to be well within the delay margin; none: no change of that "
    "kind makes the loop oscillate"
)


class LoopMargins(NamedTuple):
    """Margins of the linear loops of a design."""

    loops: Loops
    sample_time: float  # [s]
    plant: str  # name of the machine whose drives they are of

    def __repr__(self) -> str:
        told: dict[str, object] = {}
        for axis, loop in self.loops.items():
            own = margins(loop)
            name = f"{axis}_" if axis else ""
            told |= {f"{name}stable": own.stable, f"{name}gain_up": own.gain_up}
            told[f"{name}phase_deg"] = own.phase
        return line("LoopMargins", told)

    def _repr_html_(self) -> str:
        told: dict[str, object] = {}
        for axis, loop in self.loops.items():
            own = rows(margins(loop), self.sample_time)
            told |= {f"{axis}: {name}" if axis else name: text for name, text in own}
        return table("linear loop, opened at the command", told)

    def numbers(self) -> Json:
        """What ``hfc stability --json`` prints."""
        return numbers(self.loops, self.sample_time)

    def figure(self) -> "Figure":
        """Magnitude and phase of the open loops."""
        return loop_figure(self.loops, self.sample_time)

    def show(self) -> None:
        """Print the margins as a table, a column for each axis."""
        caption = f"On the plant {self.plant}. {about(self.loops)}"
        shown = Table(caption=caption, caption_justify="left")
        shown.add_column("linear loop, opened at the command", no_wrap=True)
        for axis in self.loops:
            shown.add_column(axis or "value", justify="right")
        each = [rows(margins(loop), self.sample_time) for loop in self.loops.values()]
        for own in zip(*each, strict=True):
            shown.add_row(own[0][0], *(text for _, text in own))
        show_whole(shown)


def numbers(loops: Loops, sample_time: float) -> Json:
    """Margins and poles of every axis as plain data."""
    found = {}
    for axis, loop in loops.items():
        own = margins(loop)
        poles = [{"real": pole.real, "imaginary": pole.imag} for pole in own.poles]
        found[axis or "axis"] = {**own._asdict(), "poles": poles}
    return {"sample_time": sample_time, "axes": found}


def about(loops: Loops) -> str:
    """What the margins are of."""
    told = dict.fromkeys(loop.about for loop in loops.values() if loop.about)
    return ". ".join([*told, ABOUT])


def rows(found: Margins, sample_time: float) -> list[tuple[str, str]]:
    """Margins in words; a loop that oscillates by itself has none."""
    told = _told if found.stable else lambda value: "-"
    return [
        ("stable", "yes" if found.stable else "no"),
        ("gain margin upwards, factor", told(found.gain_up)),
        ("gain margin downwards, factor", told(found.gain_down)),
        ("phase margin [deg]", told(found.phase)),
        ("delay margin [samples]", told(found.delay)),
        ("delay margin [ms]", told(found.delay and 1e3 * sample_time * found.delay)),
        ("slowest pole, magnitude", _near_one(abs(found.poles[0]))),
    ]


def _near_one(magnitude: float) -> str:
    """Four digits, or as many as tell how far it is from 1, where a loop begins to oscillate."""
    away = abs(1.0 - magnitude)
    return f"{magnitude:.{max(3, 1 - floor(log10(away))) if away > 1e-12 else 3}f}"


def _told(value: float | None) -> str:
    return NONE if value is None else f"{value:.4g}"


def loop_figure(loops: Loops, sample_time: float) -> "Figure":
    """Magnitude and phase of the open loops against the frequency [Hz]."""
    from hfc_design.pictures.figure import OTHER, OWN, framed, gridded

    figure = framed(4.6, top=0.3)
    size, phase = figure.subplots(2, sharex=True)
    angles = np.pi * np.geomspace(1e-4, 1.0, 1500)
    for (axis, loop), color in zip(loops.items(), (OWN, OTHER, "0.4") * 4, strict=False):
        response, hertz = loop.transfer(angles), angles / (2.0 * np.pi * sample_time)
        size.loglog(hertz, np.abs(response), color=color, lw=1.6, label=axis)
        phase.semilogx(hertz, lag(response), color=color, lw=1.6)
    size.axhline(1.0, color="0.3", lw=0.9)
    phase.axhline(-180.0, color="0.3", lw=0.9)
    gridded(size, y="magnitude [1]")
    gridded(phase, "frequency [Hz]", "phase [deg]")
    if len(loops) > 1:
        size.legend(fontsize=9, frameon=False)
    for part in (size, phase):
        part.yaxis.set_label_coords(-0.125, 0.5)
    return figure


def lag(response: Floats) -> Floats:
    """Phase [deg] without jumps, such that at the lowest frequency it lies between -315 and 45.

    There it is a multiple of -90 for every integrator: with three of them -270, which else would
    be drawn as +90 and the crossing of the magnitude a whole turn above the -180 that it is near.
    """
    turned = np.degrees(np.unwrap(np.angle(response)))
    return np.asarray(turned - 360.0 * np.ceil((turned[0] - 45.0) / 360.0))
