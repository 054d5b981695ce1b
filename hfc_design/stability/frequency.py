"""Frequency responses of a loop, from a log or a simulation: margins, tables, Bode and Nyquist.

Every response is (machines, frequencies), the nominal machine first, at a *source*: a log, or a
design with one amplitude of its sines. Never imports JAX.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Json, Mask, storable
from hfc_design.core.tables import MISSING, Table, line, text
from hfc_design.stability.margins import sampled_margins
from hfc_design.stability.report import lag

if TYPE_CHECKING:
    from matplotlib.axes import Axes  # takes longer than all the rest
    from matplotlib.figure import Figure

#: Coherence below which a response is not shown: with it, its error is about a third.
KNOWN = 0.5
#: Most frequencies that are drawn.
POINTS = 250
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
    "Limit cycles at rest. Predicted: the loop, driven by a sine of this amplitude, answers with "
    "the same sine (describing function); simulated: what remains of an oscillation; –: nothing"
)
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
    drive: Any  # from command to the position that is fed back
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

    @property
    def lines(self) -> list[str]:
        """What else the response says, a line each."""
        none = f"no frequency has a coherence of {KNOWN:g} or more"
        return [
            *([] if self.known.any() else [none]),
            *(
                f"mode at {x.hz:.4g} ± {2 * x.error_hz:.2g} Hz, damping {x.damping:.2g} ± "
                f"{2 * x.error_damping:.1g} of the critical one (95 %)"
                for x in self.modes
            ),
            *self.notes,
        ]

    def numbers(self) -> Json:
        """Return all but the single machines, for JSON; angles in degrees."""
        curves: Json = {}
        for name in ("drive", "loop", "compliance"):
            values = getattr(self, name)
            if values is not None:
                low, high = np.quantile(np.abs(values), ENDS, axis=0)
                sizes = {"magnitude": np.abs(values[0]), "low": low, "high": high}
                curves[name] = {key: x.tolist() for key, x in sizes.items()}
                curves[name]["phase_deg"] = lag(values[0]).tolist()
        margins = {
            key: storable({"nominal": x[0], "low": low, "high": high})
            for key, x in self.margins.items()
            for low, high in [np.quantile(x, ENDS)]
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
        keys = [
            key for key in COLUMNS if any(np.isfinite(x.get(key, np.nan)).any() for _, x in each)
        ]
        head = ["source", "from [Hz]", "to [Hz]", *(COLUMNS[x].format(units[1]) for x in keys)]
        rows, lines = [], list[str]()
        for one, margins in each:
            known = one.hertz[one.known]
            row = [one.source, *map(_cell, (known[0], known[-1]) if known.size else (np.nan,) * 2)]
            for key in keys:
                values = margins.get(key, np.array([np.nan]))
                ends = "..".join(map(_cell, np.quantile(values, ENDS)))
                row.append(_cell(values[0]) + f"\n{ends}" * (len(values) > 1))
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
            rows.append([kind, *map(_cell, (one.hz, one.position, one.command))])
            if one.stable:
                remained = (one.simulated_hz, one.simulated_position, one.simulated_command)
                rows.append(["simulated", *map(_cell, remained)])
        return Table(f"{CYCLES}.", head, rows) if rows else text("no limit cycle is predicted")

    def figure(self) -> "Figure":
        """Draw all responses, see ``drawn``."""
        return drawn(self.responses)


def _cell(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else MISSING


def drawn(responses: Sequence[FrequencyResponse]) -> "Figure":
    """Draw all responses over one another, with bands between 5 and 95 % of the machines.

    On the left magnitude and phase of the drive and the coherence; on the right magnitude of the
    open loop, its Nyquist curve, sensitivity and compliance, as far as they are known.
    """
    from hfc_design.plotting.figure import above, colour, framed, gridded

    figure = framed(8.6, top=0.5 + 0.18 * (len(responses) // 2), left=0.7, right=0.15, bottom=0.45)
    figure.set_size_inches(9.6, 8.6)
    figure.subplots_adjust(left=0.08, right=0.985, hspace=0.38, wspace=0.24)
    (size, loop), (phase, peak), (trust, soft), (nyquist, closed) = figure.subplots(4, 2)
    for k, one in enumerate(map(_fewer, responses)):
        look: dict[str, Any] = {"color": colour(k), "lw": 1.5}
        band: dict[str, Any] = {"color": colour(k), "alpha": 0.18, "lw": 0}
        shown = one.known
        trust.semilogx(one.hertz, one.coherence, **look, label=one.source)
        _curve(size, one, np.abs(one.drive), shown, look, band)
        turned = np.zeros(one.drive.shape)
        turned[:, shown] = [lag(x[shown]) for x in one.drive]
        _curve(phase, one, turned, shown, look, band)
        if one.loop is not None:
            _curve(loop, one, np.abs(one.loop), shown, look, band)
            _curve(peak, one, np.abs(1.0 / (1.0 + one.loop)), shown, look, band)
            _curve(closed, one, np.abs(one.loop / (1.0 + one.loop)), shown, look, band)
            nyquist.plot(one.loop[0].real[shown], one.loop[0].imag[shown], **look)
        if one.compliance is not None:
            _curve(soft, one, np.abs(one.compliance), shown | True, look, band)
    for axes in (size, loop, peak, soft, closed):
        axes.set_yscale("log")
    for axes in (loop, closed):
        axes.axhline(1.0, color="0.3", lw=0.8)
    nyquist.plot([-1.0], [0.0], "+", color="black", ms=9)
    nyquist.set(xlim=(-3.0, 1.0), ylim=(-2.0, 1.0))
    gridded(nyquist, "real part of L", "imaginary part of L")
    labels = {
        size: f"|drive| [{responses[0].units[0]}]",
        phase: "phase of the drive [deg]",
        trust: "coherence [1]",
        loop: "|L| [1]",
        peak: "|1 / (1 + L)| [1]",
        closed: "|L / (1 + L)| [1]",
        soft: f"compliance [{responses[0].units[1]}]",
    }
    for axes, label in labels.items():
        gridded(axes, "frequency [Hz]" if axes in (trust, closed) else "", label)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
    trust.set_ylim(0.0, 1.05)
    above(figure, trust)
    return figure


def _fewer(one: FrequencyResponse) -> FrequencyResponse:
    """Return a response at so few frequencies that a picture can show them all."""
    keep = np.unique(np.geomspace(1, len(one.hertz), POINTS).astype(int)) - 1
    known = {"hertz", "drive", "coherence", "loop", "compliance"}
    parts = {
        name: x[..., keep] for name, x in one._asdict().items() if name in known and x is not None
    }
    return one._replace(**parts)


def _curve(
    axes: "Axes", one: FrequencyResponse, values: Floats, shown: Mask, look: Any, band: Any
) -> None:
    """Draw values (machines, frequencies) of the nominal machine, and the band of the others."""
    hertz = one.hertz[shown]
    axes.plot(hertz, values[0, shown], **look)
    if len(values) > 1:
        axes.fill_between(hertz, *np.quantile(values[:, shown], ENDS, axis=0), **band)
