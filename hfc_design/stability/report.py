"""Results for ``hfc stability``, pages and ``usable``: margins of loops, stable range of JK04."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from math import ceil, inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hfc_design.core.numbers import Json, Parameters
from hfc_design.core.records import UserError, option
from hfc_design.core.tables import MISSING, Table, line, table
from hfc_design.stability.frequency import BANDS, ENDS, FrequencyResponse, cell, drawn
from hfc_design.stability.margins import ASKED, OpenLoop

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # takes longer than all the rest

    from hfc_design.stability.stable_range import StableRange  # with SciPy
    from plants import Drive  # which imports JAX

#: Number of frequencies that are drawn.
FREQUENCIES = 1500
#: Columns of the table of margins: key of a number -> title with its unit.
COLUMNS = {
    "gain_down": "gain down",
    "gain_up": "gain up",
    "phase_deg": "phase [deg]",
    "delay_samples": "delay [samples]",
    "sensitivity": "Ms [1]",
    "sensitivity_hz": "at [Hz]",
    "disk": "disk [1]",
    "crossover_hz": "crossover [Hz]",
    "bandwidth_hz": "band [Hz]",
    "compliance": "compliance [{}]",
}
ABOUT = (
    "Each loop of the simulation opened at its command, linearised in steady motion at a "
    "speed: with its sensors, observer, delay and friction, without converter steps and "
    "limits. Gain: factors up to which it is stable; phase, delay: additional lag that "
    "it tolerates; Ms: largest sensitivity |1 / (1 + L)|; disk: of gain and phase "
    "together; band: of the closed loop, -3 dB; compliance: largest |position / load|; "
    "–: no such change makes it oscillate"
)
#: Text on each of ``ASKED``, with {} for its number.
SAID = {
    "sensitivity": "largest sensitivity Ms {}",
    "gain_margin": "gain margin {}",
    "phase_margin_deg": "phase margin {} deg",
    "delay_margin_samples": "delay margin {} samples",
    "bandwidth_hz": "bandwidth {} Hz",
    "closed_loop_peak": "largest closed-loop gain Mt {}",
    "compliance": "compliance {}",
}
#: Shares of the largest K_1 at which K_2 bounds are listed.
SHARES = (0.1, 0.3, 0.5, 0.7, 0.9)
#: (K_1, K_2) of rule tables [unit/BLU], by the method that found them.
Points = Mapping[str, tuple[float, float]]
MARKERS = "os^Dv*"
#: Factor on the K_2 of the range at the smallest K_1; larger values of K_2 are not drawn.
BEYOND = 4.0
#: Meaning of inside and outside the range.
WITHOUT = (
    "the drive has no friction here; a design outside may still settle in one motion, "
    "which hfc score simulates"
)
#: Height of a line of the legend [in].
LINE = 0.19


class At(NamedTuple):
    """Loop of one axis at an operating point."""

    point: str
    axis: str  # "" where there is one
    why: str  # reason why there are no margins; "" if there are
    numbers: dict[str, float | bool | None]  # of the nominal machine; None: unlimited
    band: dict[str, tuple[float | None, float | None]]  # over other machines
    loop: OpenLoop | None  # of the nominal machine

    @property
    def name(self) -> str:
        """Name of the loop in tables."""
        return " ".join(filter(None, (self.axis, self.point)))


class LoopMargins(NamedTuple):
    """Margins of a design's loops at the operating points of a scenario."""

    rows: Sequence[At]
    sample_time: float  # [s]
    plant: str  # name of the machine
    units: str  # of the compliance
    machines: int  # number beside the nominal one

    def __repr__(self) -> str:
        return line("LoopMargins", {"stable": self.stable, **self._worst()})

    def _repr_html_(self) -> str:
        return table("worst margins of the loop, opened at the command", self._worst())

    def _worst(self) -> dict[str, float | None]:
        return {name: value for name, (value, _) in self.worst.items()}

    @property
    def stable(self) -> bool | None:
        """Whether nominal loops are stable at the lowest and the highest speed; None: no loops.

        Other speeds are not judged: there, friction that falls with the speed may destabilise the
        loop, which simulated motions show.
        """
        each: dict[str, list[bool]] = {}
        for row in self.rows:
            if not row.why:
                each.setdefault(row.axis, []).append(bool(row.numbers["stable"]))
        return all(one[0] and one[-1] for one in each.values()) if each else None

    @property
    def crossover(self) -> float | None:
        """Highest frequency where a nominal loop has the magnitude 1 [Hz]; None: there is none."""
        each = [row.numbers["crossover_hz"] for row in self.rows if not row.why]
        return max((x for x in each if x), default=None)

    @property
    def worst(self) -> dict[str, tuple[float | None, str]]:
        """Worst value of each of ``ASKED`` for the nominal machine, and its loop; None: unlimited.

        An unstable loop has the margin 0; it has no finite sensitivity, for which None stands too.
        """
        worst = {}
        for name, (key, more, _) in ASKED.items():
            each = [(_value(row, key, more), row.name) for row in self.rows if not row.why]
            if each:
                value, where = (max if more else min)(each, key=lambda one: one[0])
                worst[name] = (value if np.isfinite(value) else None), where
        return worst

    def broken(self, limits: Mapping[str, float]) -> dict[str, tuple[float | None, str]]:
        """Return the worst value and a text with its loop for each violated limit."""
        violations = {}
        for name, limit in limits.items():
            value, where = self.worst.get(name, (None, ""))
            more, least = ASKED[name][1], "at least "
            if value is None and (not more or not where):
                continue
            if value is None or (value > limit if more else value < limit):
                actual = SAID[name].format(f"{value:.3g}") if value else "the loop is unstable"
                at = where if where == "at rest" else f"at {where}"
                allowed = f"{'' if more else least}{limit:g}"
                violations[name] = value, f"{actual} {at}, allowed {allowed}"
        return violations

    def numbers(self) -> Json:
        """Return the output of ``hfc stability --json``."""
        rows = [
            {"point": one.point, "axis": one.axis, **({"why": one.why} if one.why else {})}
            | one.numbers
            | {"band": {key: [*ends] for key, ends in one.band.items()}}
            for one in self.rows
        ]
        worst = {name: {"value": value, "at": at} for name, (value, at) in self.worst.items()}
        summary = {"sample_time": self.sample_time, "plant": self.plant, "machines": self.machines}
        return {**summary, "stable": self.stable, "worst": worst, "points": rows}

    def figure(self) -> "Figure":
        """Draw the open loops and their sensitivities over frequency."""
        hertz = np.geomspace(1e-4, 1.0, FREQUENCIES) / (2.0 * self.sample_time)
        angles, units = 2.0 * np.pi * self.sample_time * hertz, ("", self.units)
        about = hertz, self.sample_time, None, np.ones(FREQUENCIES), units
        loops = [(row.name, row.loop.reduced()) for row in self.rows if row.loop is not None]
        each = [FrequencyResponse(x, *about, loop.transfer(angles)[None]) for x, loop in loops]
        return drawn(each, columns=1)

    @property
    def about(self) -> str:
        """Description of the machines that the margins are for."""
        band = f"; {BANDS.format(self.machines)}" if self.machines else ""
        return f"On the plant {self.plant}. {ABOUT}{band}"

    def tables(self) -> list[Table]:
        """Return a table of the operating points: the nominal machine above the band of others."""
        head = ["at", "stable", *(title.format(self.units) for title in COLUMNS.values())]
        rows = []
        for one in self.rows:
            if one.why:
                rows.append([one.name, *[MISSING] * (len(head) - 1)])
                continue
            stable = bool(one.numbers["stable"])
            nominal = one.numbers if stable else {}
            cells = [cell(nominal.get(key), one.band.get(key, ())) for key in COLUMNS]
            rows.append([one.name, "yes" if stable else "no", *cells])
        lines = [f"{one.name}: {one.why}" for one in self.rows if one.why]
        return [Table(self.about, head, rows, lines=lines)]


def band(others: Sequence[Json]) -> dict[str, tuple[float | None, float | None]]:
    """Return the quantiles ``ENDS`` of each number over the stable ones of other machines."""
    intervals = {}
    for key in others[0] if others else ():
        if key != "stable":
            each = [inf if one[key] is None else one[key] for one in others if one["stable"]]
            if each:
                ends = np.quantile(each, ENDS, method="nearest")
                low, high = (float(x) if np.isfinite(x) else None for x in ends)
                intervals[key] = low, high
    return intervals


def _value(row: At, key: str, more: bool) -> float:
    if not row.numbers["stable"]:
        return inf if more else 0.0
    value = row.numbers[key]
    return inf if value is None else float(value)


class StableGains(NamedTuple):
    """Gains that keep a feed drive stable, and those of rule tables beside them [unit/BLU]."""

    range: "StableRange"
    points: Points  # of the design's tables; none without a design
    drive: Mapping[str, float]  # arguments of ``stable_range``
    loop: LoopMargins | None = None  # of the design, on its own scenario

    def __repr__(self) -> str:
        inside = {name: self.range.contains(*point) for name, point in self.points.items()}
        bounds = {"k1_bound": self.range.k1_bound, "k1_linear": self.range.k1_linear}
        return line("StableGains", {**bounds, **inside})

    def _repr_html_(self) -> str:
        return table("stable range, JK04 section 3; gains in unit/BLU", rows(self))

    def numbers(self) -> Json:
        """Return the output of ``hfc stability --json``."""
        gain_range = self.range
        k1 = gain_range.k1_bound * np.array(SHARES)
        k2 = zip(k1.tolist(), gain_range.k2(k1).tolist(), strict=True)
        points = {
            name: {"k1": x, "k2": y, "inside": bool(gain_range.contains(x, y))}
            for name, (x, y) in self.points.items()
        }
        return {
            "drive": dict(self.drive),
            **gain_range._asdict(),
            "k2_bounds": [{"k1": x, "k2": y} for x, y in k2],
            "points": points,
            **({"loop": self.loop.numbers()} if self.loop else {}),
        }

    def figure(self) -> "Figure":
        """Draw the bound of K_2 against K_1 (JK04 fig. 4)."""
        return stability_figure(self.range, self.points)

    def tables(self) -> list[Table]:
        """Return the table of the range, and those of the loop."""
        head = ("stable range, JK04 section 3", "value")
        loops = self.loop.tables() if self.loop else []
        return [Table(f"Gains in unit/BLU; {WITHOUT}.", head, [*rows(self).items()]), *loops]


def drive_of(
    description: str,
    axes: "Iterable[tuple[Drive, Parameters]]",
    every: float,
    given: Mapping[str, float],
) -> dict[str, float]:
    """Return the arguments of ``stable_range``: those ``given``, else those of the design.

    ``description`` says what the design is for. Of its ``axes`` the one with the largest gain
    counts; ``every`` is the sample time [s].

    Raises:
        UserError: the plant is no feed drive, and gain or time constant are not given.
    """
    linear = [drive.linear(parameters) for drive, parameters in axes if drive.linear]
    nominal = dict(zip(("gain", "time_constant"), max(linear), strict=True)) if linear else {}
    arguments = {"sample_time": every, **nominal, **given}
    if not {"gain", "time_constant"} <= arguments.keys():
        options = f"{option('gain', ...)} and {option('time_constant', ...)}"
        raise UserError(f"{description}, not a feed drive: give {options}")
    return arguments


def rows(gains: StableGains) -> dict[str, str]:
    """Return the text of each number by its title, for the table of the range."""
    gain_range, data = gains.range, gains.numbers()
    drive = gains.drive
    values = {
        "drive: K [(BLU/s)/unit]": drive["gain"],
        "drive: tau [s]": drive["time_constant"],
        "sample time T [s]": drive["sample_time"],
        "K_0 [BLU/unit]": gain_range.k0,
        "a": gain_range.a,
        "b": gain_range.b,
        "K_1 below, the range": gain_range.k1_bound,
        "K_1 below, eq. 21 as printed": gain_range.k1_printed,
        "K_1 below, linear loop": gain_range.k1_linear,
        "K_1 below, eq. 21, sign corrected": gain_range.k1_theorem,
        **{f"K_2 below, at K_1 = {p['k1']:.5g}": p["k2"] for p in data["k2_bounds"]},
    }
    table = {name: f"{value:.6g}" for name, value in values.items()}
    for name, point in data["points"].items():
        where = "inside" if point["inside"] else "outside"
        table[f"{name}: K_1, K_2"] = f"{point['k1']:.4g}, {point['k2']:.4g} {where}"
    return table


def stability_figure(gain_range: "StableRange", points: Points) -> "Figure":
    """Draw the bound of K_2 against K_1 [unit/BLU], the range shaded, ``points`` by their names."""
    from hfc_design.plotting.figure import OTHER, OWN, framed

    top = 0.15 + LINE * ceil((3 + len(points)) / 2)
    figure = framed(3.4 + top, top)
    axes = figure.subplots()
    inside = np.linspace(0.0, gain_range.k1_bound, 201)[1:]
    beyond = np.linspace(gain_range.k1_bound, gain_range.k1_printed, 51)
    bound = gain_range.k2_printed(inside)
    axes.fill_between(inside, bound, color=OWN, alpha=0.15, lw=0, label="stable range")
    axes.plot(inside, bound, color=OWN, lw=1.8)
    if gain_range.k1_bound < gain_range.k1_printed:
        axes.plot(beyond, gain_range.k2_printed(beyond), color=OWN, lw=1, ls=":", label="printed")
    axes.axvline(gain_range.k1_linear, color=OTHER, lw=1.2, ls="--", label="linear limit")
    for marker, (name, (k1, k2)) in zip(cycle(MARKERS), points.items(), strict=False):
        axes.plot([k1], [k2], color="black", mfc="none", ls="", marker=marker, ms=6, label=name)
    axes.set(xlabel="$K_1$ [unit/BLU]", ylabel="$K_2$ [unit/BLU]", axisbelow=True)
    highest, end = max(k2 for _, k2 in points.values()) if points else 0.0, BEYOND * bound[0]
    axes.set(xlim=(0.0, None), ylim=(0.0, end if highest > end else None))
    axes.grid(color="0.9")
    figure.legend(fontsize=9, frameon=False, ncols=2, loc="upper center")
    return figure
