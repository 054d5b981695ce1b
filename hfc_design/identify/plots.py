"""Pictures of what a log tells: the replay, what is left of it and at which frequencies."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import welch

from hfc_design.core.numbers import Floats
from hfc_design.identify.checks import Check
from hfc_design.identify.identified import Identified
from hfc_design.identify.profile import LIMIT, Profile
from hfc_design.pictures.figure import OTHER, OWN, above, finish, framed, gridded, plain, readable

#: So many points of a curve are drawn.
POINTS = 1500
#: Share of a log in which one spectrum is formed, at most so many samples.
SEGMENT = 8192


def replayed(found: Identified) -> Figure:
    """The recorded motion, its command, and what the replay is off."""
    told, unit = found.told, found.position_unit
    time = told.sample_time * np.arange(len(told.place), dtype=float)
    figure = framed(5.6, top=0.35)
    axes = figure.subplots(3, sharex=True)
    axes[0].plot(*thinned(time, told.place), color=OWN, lw=0.8, label="recorded")
    if told.reference is not None:
        axes[0].plot(*thinned(time, told.reference), "--", color="0.4", lw=0.8, label="reference")
    finish(axes[0], f"position [{unit}]")
    if told.command is not None:
        axes[1].plot(*thinned(time, told.command), color="0.3", lw=0.8)
    finish(axes[1], f"command [{found.free.drive.units['command']}]")
    left = found.found.fit.residual[:, 0]
    factor, small = readable(unit, float(np.abs(left).max()))
    axes[2].plot(*thinned(time, factor * left), color=OTHER, lw=0.8)
    finish(axes[2], f"off [{small}]", "time [s]")
    above(figure, axes[0])
    return figure


def checked(found: Identified) -> Figure:
    """What each log and each way of replay leaves."""
    checks, unit = found.checks, found.position_unit
    figure = framed(0.9 + 1.35 * len(checks), top=0.3)
    axes = np.atleast_1d(figure.subplots(len(checks)))
    for own, check in zip(axes, checks, strict=True):
        factor, small = readable(unit, float(np.abs(check.residual).max()))
        time = found.told.sample_time * np.arange(len(check.residual))
        own.plot(*thinned(time, factor * check.residual), color=OTHER, lw=0.7)
        finish(own, f"off [{small}]", "time [s]" if own is axes[-1] else "")
        own.set_title(plain(f"{check.log}: {check.how}"), fontsize=8, parse_math=False)
    figure.subplots_adjust(hspace=0.6)
    return figure


def spectrum(found: Identified) -> Figure:
    """At which frequencies the replay is off."""
    figure = framed(2.8, top=0.35)
    axes = figure.subplots()
    unit, every = found.position_unit, found.told.sample_time
    colours = (OWN, OTHER, "#009E73", "0.4")
    for check, colour in zip(found.checks[: len(colours)], colours, strict=False):
        frequency, density = _density(check, every)
        axes.loglog(
            frequency, density, color=colour, lw=0.9, label=plain(f"{check.log}: {check.how}", 60)
        )
    gridded(axes, "frequency [Hz]", f"off [{unit}/√Hz]")
    above(figure, axes, 7.0, 1)
    figure.subplots_adjust(top=1 - (0.2 + 0.17 * len(found.checks)) / 2.8)
    return figure


def profiled(profile: Profile, unit: str) -> Figure:
    """How the fit grows worse while one parameter is held off its value."""
    figure = framed(2.2, top=0.15)
    axes = figure.subplots()
    axes.plot(profile.values, profile.worse, "o-", color=OWN, ms=4, lw=1)
    axes.axhline(LIMIT, color="0.5", lw=0.8, ls="--")
    axes.set_ylim(0.0, max(2.0 * LIMIT, min(float(profile.worse.max()), 5 * LIMIT)))
    finish(axes, "worse by [1]", f"{profile.name} [{unit or '1'}]")
    return figure


def _density(check: Check, every: float) -> tuple[Floats, Floats]:
    """Frequencies [Hz] and the root of the power density there."""
    length = min(SEGMENT, len(check.residual))
    frequency, power = welch(check.residual, 1.0 / every, nperseg=length)
    return frequency[1:], np.sqrt(power[1:])


def thinned(time: Any, values: Any) -> tuple[Floats, Floats]:
    """A curve by the least and the largest of each part, so that no peak is lost."""
    if len(time) <= POINTS:
        return time, values
    width = -(-2 * len(time) // POINTS)
    whole = len(time) // width * width
    rows = values[:whole].reshape(-1, width)
    both = np.stack([rows.min(axis=1), rows.max(axis=1)], axis=1).ravel()
    return np.repeat(time[:whole:width], 2), both
