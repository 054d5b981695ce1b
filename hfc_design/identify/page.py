"""The page of an identification with its pictures, and its folder."""

import json
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.signal import welch

from hfc_design.core.numbers import Floats
from hfc_design.core.plugins import given, options
from hfc_design.formats.writing import Content
from hfc_design.formats.writing import write as write_files
from hfc_design.identify.identifiability import CONFIDENCE, GIVEN
from hfc_design.identify.identified import Identified
from hfc_design.identify.profiles import LIMIT, Profile
from hfc_design.identify.scenario import scenario_text
from hfc_design.plotting.curves import thinned
from hfc_design.plotting.figure import OTHER, OWN, above, finish, framed, gridded, plain
from hfc_design.plotting.files import small_address
from hfc_design.plotting.numbers import readable
from hfc_design.report import REPORT, Page, rendered

#: Least number of parts averaged for a spectrum, and most samples of a part.
PARTS, SEGMENT = 4, 8192
#: Samples shown on each side of the largest residual: share of the log, and least number.
NEAR, FEW = 0.01, 25
#: Relative width of a profile below which an axis cannot show it.
SEEN = 1e-5


def write(result: Identified, path: Path, command: str) -> None:
    """Write the folder of a result: page, numbers, and the scenario for a search.

    ``command`` is the command line that produced the result; the page shows it.

    Raises:
        UserError, RunError: no valid scenario can hold the result, or the folder cannot be written.
    """
    texts: dict[str, Content] = {
        "scenario.toml": scenario_text(result),
        "identified.json": json.dumps(result.numbers(), indent=1) + "\n",
        REPORT: page(result, command).html,
    }
    write_files(path, texts)


def page(result: Identified, command: str) -> Page:
    """Return the page of a result as a self-contained HTML file."""
    parameters, checks = result.tables()
    doubts = [note for note in result.notes if note.startswith(("DOUBTFUL", "NOT USABLE"))]
    return rendered(
        "identified.html.j2",
        f"{result.free.drive.name} from {result.log}",
        small_address,
        found=result,
        plant=result.free.drive.name,
        parameters=parameters,
        checks=checks,
        confidence=100 * CONFIDENCE,
        doubts=doubts,
        notes=[note for note in result.notes if note not in doubts],
        given=GIVEN in result.known.state,
        profiles={x.name: profiled(x, result.free.unit(x.name)) for x in result.profiles},
        limit=LIMIT,
        command=command,
        use=options(text for _, text in given()),
        replayed=replayed(result),
        closely=closely(result),
        checked=checked(result),
        spectrum=spectrum(result),
        response=response(result),
    )


def counted(residual: Floats) -> Floats:
    """Return a residual (steps,) with nan for the zeros at its start, where it does not count."""
    return np.where(np.cumsum(residual != 0) > 0, residual, np.nan)


def replayed(result: Identified) -> Figure:
    """Return a figure of recorded and replayed positions, the command, and the residual."""
    log, unit = result.recording, result.position_unit
    time, panels = _time(result), 2 + (log.command is not None)
    figure = framed(0.6 + 1.75 * panels, top=0.35)
    first, *others = figure.subplots(panels, sharex=True)
    first.plot(*thinned(time, log.place), color="0.65", lw=2.5, label="recorded")
    simulated = log.place - counted(result.checks[0].residual)
    first.plot(*thinned(time, simulated), color=OWN, lw=1.0, label="replayed")
    if log.reference is not None:
        first.plot(*thinned(time, log.reference), ":", color="black", lw=1.0, label="reference")
    finish(first, f"position [{unit}]")
    if log.command is not None:
        others[0].plot(*thinned(time, log.command), color="0.3", lw=0.8)
        finish(others[0], f"command [{result.free.drive.units['command']}]")
    _draw_off(others[-1], result, result.checks[0].residual, "time [s]")
    above(figure, first, columns=3)
    return figure


def closely(result: Identified) -> Figure:
    """Return a figure of positions and residual around the largest residual, with all samples."""
    off, unit = result.checks[0].residual, result.position_unit
    worst, width = int(np.abs(off).argmax()), max(int(NEAR * len(off)), FEW)
    near = slice(max(worst - width, 0), worst + width + 1)
    time = _time(result)[near]
    place, replay = result.recording.place[near], (result.recording.place - off)[near]
    middle = time - time.mean()
    cubic = np.polyval(np.polyfit(middle, place, 3), middle)  # without it small errors are visible
    factor, small = readable(unit, float(np.abs(place - cubic).max()))
    figure = framed(4.1, top=0.35)
    upper, lower = figure.subplots(2, sharex=True)
    upper.plot(time, factor * (place - cubic), "o", color="0.6", ms=4, label="recorded")
    upper.plot(time, factor * (replay - cubic), color=OWN, lw=1.0, label="replayed")
    finish(upper, f"position less cubic [{small}]")
    factor = _draw_off(lower, result, off, "time [s]", near)
    lower.plot(time[worst - near.start], factor * off[worst], "o", color=OTHER, ms=5)
    above(figure, upper)
    return figure


def checked(result: Identified) -> Figure | None:
    """Return a figure of the residuals of all checks but the first; None if there are no others."""
    _, *checks = result.checks
    if not checks:
        return None
    figure = framed(0.9 + 1.5 * len(checks), top=0.3)
    for axes, check in zip(np.atleast_1d(figure.subplots(len(checks))), checks, strict=True):
        _draw_off(axes, result, check.residual, "time [s]" if check is checks[-1] else "")
        axes.set_title(plain(f"{check.log}: {check.how}"), fontsize=9, parse_math=False)
    figure.subplots_adjust(hspace=0.6)
    return figure


def spectrum(result: Identified) -> Figure:
    """Return a figure with the spectra of the residuals of the first four checks."""
    figure = framed(2.8 + 0.2 * len(result.checks), top=0.2 + 0.2 * len(result.checks))
    axes = figure.subplots()
    unit, every = result.position_unit, result.recording.sample_time
    styles = ((OWN, "-"), (OTHER, "-"), (OWN, "--"), (OTHER, "--"))
    for check, (colour, style) in zip(result.checks, styles, strict=False):
        length = min(SEGMENT, -(-len(check.residual) // PARTS))
        frequency, power = welch(check.residual, 1.0 / every, nperseg=length)
        label = plain(f"{check.log}: {check.how}", 60)
        density = np.sqrt(power[1:])
        axes.loglog(frequency[1:], density, style, color=colour, lw=0.9, label=label)
    gridded(axes, "frequency [Hz]", f"off [{unit}/√Hz]")
    above(figure, axes, 8.0, 1)
    return figure


def response(result: Identified) -> Figure | None:
    """Return a figure of the responses of log and model, and the coherence; None: no response."""
    answer = result.response
    if answer is None:
        return None
    figure = framed(4.4, top=0.35)
    upper, lower = figure.subplots(2, sharex=True, height_ratios=(2, 1))
    upper.loglog(answer.frequency, np.abs(answer.log), color="0.6", lw=2.0, label="log")
    upper.loglog(answer.frequency, np.abs(answer.model), color=OWN, lw=1.0, label="model")
    lower.plot(answer.frequency, answer.coherence, color="0.3", lw=0.8)
    for axes in (upper, lower):
        axes.axvspan(answer.unknown_above, answer.frequency[-1], color="0.93", lw=0)
        if answer.mode:
            axes.axvline(answer.mode.hz, color=OTHER, lw=1.0)
    upper.set_xlim(answer.frequency[0], answer.frequency[-1])
    gridded(upper, "", f"[{result.position_unit}/{result.free.drive.units['command']}]")
    gridded(lower, "frequency [Hz]", "coherence [1]")
    above(figure, upper)
    return figure


def profiled(profile: Profile, unit: str) -> Figure | None:
    """Return a figure that shows how much worse the fit is at other values of one parameter.

    None if the range of values is too narrow for an axis.
    """
    values = profile.values
    if np.ptp(values) <= SEEN * np.abs(values).max():
        return None
    figure = framed(2.8, top=0.35)
    axes = figure.subplots()
    axes.plot(*profile.supposed, "--", color="0.5", lw=1.2, label="parabola of its interval")
    axes.plot(values, profile.worse, "o", color=OWN, ms=5, label="fitted again")
    axes.axhline(LIMIT, color=OTHER, lw=1.0)
    level = f"{100 * CONFIDENCE:g} %: {LIMIT:.3g}"
    axes.text(
        0.5, 1.03 * LIMIT, level, transform=axes.get_yaxis_transform(), color=OTHER, ha="center"
    )
    axes.set_ylim(0.0, max(2.0 * LIMIT, min(1.05 * float(profile.worse.max()), 5 * LIMIT)))
    finish(axes, "2 × fall of log likelihood [1]", f"{profile.name} [{unit or '1'}]")
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5))
    axes.ticklabel_format(axis="x", useOffset=False)
    above(figure, axes)
    return figure


def _draw_off(
    axes: Axes, result: Identified, residual: Floats, x: str, part: slice = slice(None)
) -> float:
    """Draw recorded less replayed position; return the factor to the unit of its axis."""
    factor, unit = readable(result.position_unit, float(np.abs(residual).max()))
    time = result.recording.sample_time * np.arange(len(residual), dtype=float)
    axes.plot(*thinned(time[part], factor * counted(residual)[part]), color=OTHER, lw=0.8)
    axes.set_xlim(time[part][0], time[part][-1])  # includes the start, which may not count
    finish(axes, f"off by [{unit}]", x)
    return factor


def _time(result: Identified) -> Floats:
    """Return the time (steps,) of the samples of the log [s]."""
    return result.recording.sample_time * np.arange(len(result.recording.place), dtype=float)
