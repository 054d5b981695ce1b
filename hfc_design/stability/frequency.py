"""Frequency responses of a loop, from a log or a simulation: margins, tables, Bode and Nyquist.

Every response is (machines, frequencies), the nominal machine first, at a *source*: a log, or a
design with one amplitude of its sines. Never imports JAX.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Json, Mask, storable
from hfc_design.core.tables import MISSING, Table, line, text
from hfc_design.stability.margins import sampled_margins

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # takes longer than all the rest

#: Coherence below which a response is not shown: with it, its error is about a third.
KNOWN = 0.5
#: Most frequencies that are drawn, and height of a panel [in].
POINTS, PANEL = 1500, 1.9
#: Fields of ``FrequencyResponse`` with a number for each frequency that are drawn.
CURVES = ("hertz", "drive", "coherence", "loop", "compliance")
#: Quantiles of the machines that bound a band.
ENDS = (0.05, 0.95)
#: Columns of the table: key of a number -> title with its unit.
COLUMNS = {
    "crossover_hz": "crossover [Hz]",
    "phase_deg": "phase [deg]",
    "gain_up": "gain [1]",
    "sensitivity": "Ms [1]",
    "sensitivity_hz": "at [Hz]",
    "peak": "Mt [1]",
    "bandwidth_hz": "band [Hz]",
    "compliance": "compliance [{}]",
}
ABOUT = (
    "Loop opened at its command. From, to: where the coherence is at least {}; phase, gain: "
    "margins; Ms: largest |1 / (1 + L)|; Mt: largest |L / (1 + L)|, band: where that is -3 dB; "
    "compliance: largest |position / load|; –: not among these frequencies"
)
CYCLES = (
    "Limit cycles at rest. Predicted: the open loop, driven by this oscillation, answers with the "
    "same one (describing function; of stable ones with overtones); simulated: what remains of an "
    "oscillation; –: nothing"
)
#: Labels of the Nyquist curve and of logarithmic panels; values that are marked in others.
NYQUIST, REAL = "imaginary part of L", "real part of L"
LOGARITHMIC = ("|", "compliance")
MARKED = {
    "|L| [1]": 1.0,
    "|L / (1 + L)| [1]": 1.0,
    "phase of L [deg]": -180.0,
    "coherence [1]": 0.0,
}
BANDS = "below: between 5 and 95 % of {} other machines"


class Mode(NamedTuple):
    """A mode that a response shows."""

    hz: float
    damping: float  # as a share of the critical one
    error_hz: float  # standard error
    error_damping: float


class LimitCycle(NamedTuple):
    """A predicted limit cycle, and the one that a simulation shows; nan: none remained."""

    hz: float
    command: float  # amplitude of the drive's command, within its limits
    position: float  # amplitude
    driven: float  # amplitude of the command before its limits
    stable: bool  # False: smaller oscillations decay, larger ones grow
    simulated_hz: float = np.nan
    simulated_command: float = np.nan
    simulated_position: float = np.nan


class FrequencyResponse(NamedTuple):
    """Responses of one source, complex (machines, frequencies)."""

    source: str
    hertz: Floats
    sample_time: float  # [s]
    drive: Any  # from command to the position that is fed back; None: unknown
    coherence: Floats  # (frequencies,) 1: the answer is that of a linear loop without noise
    units: tuple[str, str]  # of drive and compliance
    loop: Any = None  # open loop L; None: unknown
    compliance: Any = None  # from load to position; None: unknown
    error: Floats | None = None  # (frequencies,) relative standard error of the drive's response
    modes: tuple[Mode, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def known(self) -> Mask:
        """Frequencies whose coherence is at least ``KNOWN``."""
        return np.asarray(self.coherence >= KNOWN)

    @property
    @np.errstate(all="ignore")  # L is -1 where a machine oscillates by itself
    def margins(self) -> dict[str, Floats]:
        """Each of ``COLUMNS`` for all machines, (machines,); nan: not among the frequencies."""
        known, values = self.known, dict[str, Floats]()
        if self.loop is not None and known.sum() > 1:
            angles = 2.0 * np.pi * self.sample_time * self.hertz[known]
            about = (self.sample_time, 1.0 / (1.0 + self.loop[:, known]))
            values = sampled_margins(angles, *about, whole=False)
            values["peak"] = values["closed_loop_peak"]
            values = {key: values[key] for key in COLUMNS if key in values}
        if self.compliance is not None:
            values["compliance"] = np.abs(self.compliance).max(axis=1)
        return values

    @np.errstate(all="ignore")
    def curves(self) -> dict[str, tuple[Floats, Floats]]:
        """Return what a picture shows, by labels: x (points,), and values (machines, points)."""
        known, (drive_unit, soft_unit) = self.known, self.units
        hertz, curves = self.hertz[known], dict[str, tuple[Floats, Floats]]()
        if self.drive is not None:
            drive = self.drive[:, known]
            curves[f"|drive| [{drive_unit}]"] = hertz, np.abs(drive)
            curves["phase of the drive [deg]"] = hertz, lag(drive)
            curves["coherence [1]"] = self.hertz, self.coherence[None]
        if self.compliance is not None:
            curves[f"compliance [{soft_unit}]"] = self.hertz, np.abs(self.compliance)
        if self.loop is not None:
            loop = self.loop[:, known]
            curves[NYQUIST] = loop[0].real, loop[:1].imag
            curves["|L| [1]"] = hertz, np.abs(loop)
            curves["phase of L [deg]"] = hertz, lag(loop)
            curves["|1 / (1 + L)| [1]"] = hertz, np.abs(1.0 / (1.0 + loop))
            curves["|L / (1 + L)| [1]"] = hertz, np.abs(loop / (1.0 + loop))
        return curves

    @property
    def lines(self) -> list[str]:
        """What else the response says, a line each."""
        none = f"no frequency has a coherence of {KNOWN:g} or more"
        lines = [] if self.known.any() else [none]
        for x in self.modes:
            damping = f"{x.damping:.2g} ± {2 * x.error_damping:.1g} of the critical one (95 %)"
            lines.append(f"mode at {x.hz:.4g} ± {2 * x.error_hz:.2g} Hz, damping {damping}")
        return [*lines, *self.notes]

    def numbers(self) -> Json:
        """Return all but the single machines, for JSON; angles in degrees."""
        curves: Json = {}
        for name in ("drive", "loop", "compliance"):
            values = getattr(self, name)
            if values is not None:
                low, high = ends(np.abs(values))
                curve = {"magnitude": np.abs(values[0]), "low": low, "high": high}
                curve["phase_deg"] = lag(values[0])
                curves[name] = {key: x.tolist() for key, x in curve.items()}
        margins = {
            key: storable({"nominal": x[0], "low": low, "high": high})
            for key, x in self.margins.items()
            for low, high in [ends(x)]
        }
        return {
            "source": self.source,
            "machines": len(self.drive),
            "sample_time": self.sample_time,
            "units": dict(zip(("drive", "compliance"), self.units, strict=True)),
            "hz": self.hertz.tolist(),
            "coherence": self.coherence.tolist(),
            **({} if self.error is None else {"relative_error": storable(self.error.tolist())}),
            **curves,
            "margins": margins,
            "modes": [mode._asdict() for mode in self.modes],
            "notes": [*self.notes],
        }


def response_units(units: Mapping[str, str]) -> tuple[str, str]:
    """Return the units of a drive's response and of its compliance, from those of its signals."""
    load = f"({units['load']})" if " " in units["load"] else units["load"]
    return f"{units['error']}/{units['command']}", f"{units['error']}/{load}"


class Frequencies(NamedTuple):
    """Responses of several sources over one another, and the limit cycles of a design."""

    responses: Sequence[FrequencyResponse]
    cycles: Sequence[LimitCycle] | None = None  # None: not sought

    def __repr__(self) -> str:
        return line("Frequencies", {one.source: len(one.hertz) for one in self.responses})

    def numbers(self) -> Json:
        """Return the output of ``hfc frequency --json``."""
        each = [one.numbers() for one in self.responses]
        cycles = [storable(one._asdict()) for one in self.cycles or ()]
        return {"responses": each, **({} if self.cycles is None else {"limit_cycles": cycles})}

    def tables(self) -> list[Table]:
        """Return the table of margins, the nominal machine above the band of others; of cycles."""
        units = self.responses[0].units
        each = [(one, one.margins) for one in self.responses]
        there = {key for _, x in each for key, values in x.items() if np.isfinite(values).any()}
        keys = [key for key in COLUMNS if key in there]
        head = ["source", "from [Hz]", "to [Hz]", *(COLUMNS[x].format(units[1]) for x in keys)]
        rows, lines = [], list[str]()
        for one, margins in each:
            known = one.hertz[one.known]
            row = [one.source, *map(cell, (known[0], known[-1]) if known.size else (np.nan,) * 2)]
            for key in keys:
                values = margins.get(key, np.array([np.nan]))
                row.append(cell(values[0], ends(values) if len(values) > 1 else ()))
            rows.append(row)
            lines += [f"{one.source}: {sentence}" for sentence in one.lines]
        most = max(len(one.drive) for one in self.responses) - 1
        about = ABOUT.format(KNOWN) + (f"; {BANDS.format(most)}" if most else "")
        both = [Table(f"{about}.", head, rows, lines=lines)]
        return both if self.cycles is None else [*both, self._cycles(units[0])]

    def _cycles(self, units: str) -> Table:
        position, _, command = units.partition("/")
        head = ["limit cycle", "f [Hz]", f"position [{position}]", f"command [{command}]"]
        rows = []
        for one in self.cycles or ():
            kind = "predicted" if one.stable else "predicted, unstable: larger ones grow"
            rows.append([kind, *map(cell, (one.hz, one.position, one.command))])
            if one.stable:
                remained = (one.simulated_hz, one.simulated_position, one.simulated_command)
                rows.append(["simulated", *map(cell, remained)])
        return Table(f"{CYCLES}.", head, rows) if rows else text("no limit cycle is predicted")

    def figure(self) -> "Figure":
        """Draw all responses, see ``drawn``."""
        return drawn(self.responses)


def cell(value: float | None, band: Iterable[float | None] = ()) -> str:
    """Return the text of a number, above the ends of its ``band`` if there is one."""
    first = MISSING if value is None or not np.isfinite(value) else f"{value:.3g}"
    return "\n".join(filter(None, (first, "..".join(map(cell, band)))))


def ends(values: Floats) -> Floats:
    """Return both ends of the band of machines (machines, ...), each that of a machine."""
    return np.asarray(np.quantile(values, ENDS, axis=0, method="nearest"))  # inf stays inf


def drawn(responses: Sequence[FrequencyResponse], columns: int = 2) -> "Figure":
    """Draw all responses over one another, with bands between 5 and 95 % of the machines.

    Each of their ``curves`` has a panel; the Nyquist curve only if there are several ``columns``.
    """
    from matplotlib.ticker import LogLocator

    from hfc_design.plotting.figure import WIDTH, above, colour, framed, gridded

    shown = [(one.source, one.curves()) for one in map(_fewer, responses)]
    most = sorted((curves for _, curves in shown), key=len, reverse=True)
    labels = [*dict.fromkeys(label for curves in most for label in curves)]
    labels = [label for label in labels if columns > 1 or label != NYQUIST]
    rows, top = max(-(-len(labels) // columns), 1), 0.3 + 0.18 * (len(responses) // 2)
    figure = framed(PANEL * rows + top + 0.4, top=top)
    figure.set_size_inches(columns * WIDTH, figure.get_figheight())
    figure.subplots_adjust(left=0.15 / columns, right=0.985, hspace=0.38, wspace=0.24)
    each = figure.subplots(rows, columns, squeeze=False).T.ravel()
    for axes, label in zip(each, labels, strict=False):
        for k, (source, curves) in enumerate(shown):
            if label in curves:
                x, values = curves[label]
                axes.plot(x, values[0], color=colour(k), lw=1.5, label=source)
                if len(values) > 1:
                    axes.fill_between(x, *ends(values), color=colour(k), alpha=0.18, lw=0)
        gridded(axes, REAL if label == NYQUIST else "frequency [Hz]", label)
        if label == NYQUIST:
            axes.plot([-1.0], [0.0], "+", color="black", ms=9)
            axes.set(xlim=(-3.0, 1.0), ylim=(-2.0, 1.0))
            continue
        axes.set(xscale="log", yscale="log" if label.startswith(LOGARITHMIC) else "linear")
        for axis in (axes.xaxis, axes.yaxis):  # powers of ten would be in small letters
            low, high = axis.get_view_interval()
            if axis.get_scale() == "log":
                few = (1.0, 2.0, 5.0) if high < 100.0 * low else (1.0,)
                axis.set_major_locator(LogLocator(subs=few))
                axis.set_minor_formatter("")
            axis.set_major_formatter("{x:g}")
        if label in MARKED:
            axes.axhline(MARKED[label], color="0.3", lw=0.8)
    for axes in each[len(labels) :]:
        axes.remove()
    above(figure, each[0])
    return figure


def lag(response: Any) -> Floats:
    """Return phases (..., frequencies) [deg] without jumps, from -315 to 45 at the lowest one.

    Every integrator adds -90 there. With three of them the phase is -270; if +90 were drawn
    instead, the phase at the crossover would be a whole turn above the -180 that it is close to.
    """
    turned = np.degrees(np.unwrap(np.angle(response)))
    return np.asarray(turned - 360.0 * np.ceil((turned[..., :1] - 45.0) / 360.0))


def _fewer(one: FrequencyResponse) -> FrequencyResponse:
    """Return a response at so few frequencies that a picture can show them all."""
    if len(one.hertz) <= POINTS:
        return one
    keep = np.unique(np.geomspace(1, len(one.hertz), POINTS).astype(int)) - 1
    each = ((name, getattr(one, name)) for name in CURVES)
    return one._replace(**{name: x[..., keep] for name, x in each if x is not None})
