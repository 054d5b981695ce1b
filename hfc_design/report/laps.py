"""Laps that learn: tables and a picture of what they showed, and the files for a control."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from hfc_design.core.numbers import Floats, Json, storable
from hfc_design.core.tables import MISSING, Table, line, table
from hfc_design.core.wording import three_digits
from hfc_design.files.scenario import Scenario
from hfc_design.formats import sampled
from hfc_design.formats.writing import Content, write
from hfc_design.plotting.curves import thinned
from hfc_design.plotting.figure import OTHER, OWN, above, finish, framed
from hfc_design.simulation.laps import Filters

LOGGED = "Laps of logs. A lap that is worse than the best one before is not learned from."
SIMULATED = (
    "{} other machines within the tolerances, each learns from its own laps; kept: each with its "
    "best tables once more"
)


class Laps(NamedTuple):
    """What laps showed, simulated or of logs, and the table for the next lap.

    Arrays of laps are (laps, machines), the nominal machine first; logs are of one machine.
    """

    name: str  # of the design
    scenario: Scenario
    filters: Filters
    laps: tuple[str, ...]  # a name for each
    rms: Floats  # of the error of all axes
    largest: Floats  # contour error, or of one axis the error; nan: the machine diverges
    shared: Floats | None  # (machines,) the same with the table of the nominal one; None: logs
    table: Floats  # (axes, steps) for the next lap
    best: Floats  # (axes, steps) of the best lap so far, of each axis
    errors: tuple[Floats, Floats]  # (axes, steps) of the nominal machine, first and best lap

    def __repr__(self) -> str:
        return line("Laps", self._summary())

    def _repr_html_(self) -> str:
        return table("laps that learn", self._summary())

    def _summary(self) -> dict[str, object]:
        known = {"design": self.name, "scenario": self.scenario.name}
        return known | {"first": self.worst[0], "last": self.worst[-1], "unit": self._units[0]}

    @property
    def worst(self) -> list[float]:
        """The largest error of each lap on any machine that does not diverge."""
        return [float(np.nanmax(x)) if np.isfinite(x).any() else np.nan for x in self.largest]

    @property
    def _measure(self) -> str:
        return "contour error" if self.scenario.follows_path else "error"

    @property
    def _units(self) -> tuple[str, str]:
        """Units of errors and commands."""
        units = self.scenario.units.signals
        return units["error"], units["command"]

    @property
    def _time(self) -> Floats:
        return self.scenario.simulation.time

    def numbers(self) -> Json:
        """Return the output of ``hfc laps --json``."""
        shared = None if self.shared is None else float(np.nanmax(self.shared))
        rows = [
            {"lap": name, "rms_error": rms[0], "largest": most[0], "median": np.nanmedian(most)}
            | {"worst": worst, "diverged": int(np.isnan(most).sum())}
            for name, rms, most, worst in zip(
                self.laps, self.rms, self.largest, self.worst, strict=True
            )
        ]
        return {
            "design": self.name,
            "scenario": self.scenario.name,
            "machines": self.largest.shape[1],
            "measure": f"largest {self._measure}",
            "units": dict(zip(("error", "command"), self._units, strict=True)),
            "laps": [storable(row) for row in rows],
            "one_table_for_all": storable({"worst": shared})["worst"],
            "learns_to_hz": dict(zip(self.scenario.machine.axes, self.filters.hertz, strict=True)),
            "largest_command": dict(
                zip(self.scenario.machine.axes, np.abs(self.table).max(axis=1), strict=True)
            ),
        }

    def tables(self) -> list[Table]:
        """Return the table of the laps."""
        unit, several = self._units[0], self.largest.shape[1] > 1
        every_unit = dict.fromkeys(one.drive.units["error"] for one in self.scenario.plant.each())
        head = ["lap", f"rms error [{', '.join(every_unit)}]", f"largest {self._measure} [{unit}]"]
        head += ["median of all", "worst of all"] * several
        rows = []
        for name, rms, most, worst in zip(
            self.laps, self.rms, self.largest, self.worst, strict=True
        ):
            values = [rms[0], most[0], *([np.nanmedian(most), worst] if several else [])]
            rows.append([name, *(three_digits(x) if np.isfinite(x) else MISSING for x in values)])
        about = SIMULATED.format(self.largest.shape[1] - 1) if several else LOGGED
        return [Table(about, head, rows, lines=[*self._lines()])]

    def _lines(self) -> list[str]:
        pairs = zip(self.scenario.machine.axes, self.filters.hertz, strict=True)
        lines = [f"learned up to {', '.join(f'{name} {hz:.3g} Hz' for name, hz in pairs)}"]
        if self.shared is not None and len(self.shared) > 1:
            worst = three_digits(float(np.nanmax(self.shared)))
            lines.append(
                f"all machines with the table of the nominal one: worst {worst} {self._units[0]}"
            )
        if lost := int(np.isnan(self.largest).any(axis=0).sum()):
            lines.append(f"{lost} of {self.largest.shape[1]} machines diverge, and do not count")
        return lines

    def figure(self) -> Figure:
        """Draw the error of each axis in the first and in the best lap, and the table."""
        names = [
            f" {name}" if len(self.scenario.machine.axes) > 1 else ""
            for name in self.scenario.machine.axes
        ]
        figure = framed(0.9 + 1.5 * 2 * len(names), top=0.35)
        panels = figure.subplots(2 * len(names), sharex=True)
        both = ("first lap", OTHER, self.errors[0]), ("best lap", OWN, self.errors[1])
        for k, name in enumerate(names):
            for label, colour, errors in both:
                curve = thinned(self._time, errors[k])
                panels[2 * k].plot(*curve, color=colour, lw=0.8, label=label)
            panels[2 * k + 1].plot(*thinned(self._time, self.table[k]), color=OWN, lw=0.8)
            last = "time [s]" if name == names[-1] else ""
            units = self.scenario.plant.each()[k].drive.units
            finish(panels[2 * k], f"error{name} [{units['error']}]")
            finish(panels[2 * k + 1], f"table{name} [{units['command']}]", last)
        above(figure, panels[0])
        return figure

    def write(self, folder: Path) -> None:
        """Write the table for the next lap: as CSV, for C, and for LinuxCNC.

        Raises:
            RunError: the folder cannot be written.
        """
        every = self.scenario.simulation.sample_time_s
        pairs = zip(self.scenario.machine.axes, self.table, strict=True)
        columns = {name: (values, self._units[1]) for name, values in pairs}
        fading = np.hstack([self.table, self.table[:, -1:] * np.linspace(1.0, 0.0, FADING)])
        rows = {name: (values, "") for name, values in zip(columns, fading, strict=True)}
        about: dict[str, object] = {"pins": "f" * len(columns), "depth": fading.shape[1] + 1}
        about["period"] = round(1e9 * every)
        about["sums"] = ",".join(f"laps-{name}" for name in columns)
        lines = [HAL.format(**about)]
        lines += [HAL_AXIS.format(axis=name, k=k) for k, name in enumerate(columns)]
        best = {
            name: (x, volt) for (name, (_, volt)), x in zip(columns.items(), self.best, strict=True)
        }
        files: dict[str, Content] = {
            "laps.csv": sampled.csv(self._time, columns),
            "best.csv": sampled.csv(self._time, best),
            "laps.h": sampled.c_header("laps", every, columns),
            "laps.txt": sampled.streamed(rows),
            "laps.hal": "".join(lines),
        }
        write(folder, files)


#: Rows for LinuxCNC after those of the table, in which it fades to 0: the last one goes on acting.
FADING = 100
HAL = """# Laps of hfc-design for LinuxCNC: adds a table to the commands, a row in each sample.
# Source it after the controllers and before what writes to the drives. Replace NAMES in capitals.
# Before each lap: halstreamer < laps.txt. The lap begins when START is true.
# The servo thread must have a period of {period} ns.
loadrt streamer depth={depth} cfg={pins}
loadrt sum2 names={sums}
#net START => streamer.0.enable
addf streamer.0 servo-thread
"""
HAL_AXIS = """addf laps-{axis} servo-thread
net laps-{axis}-table streamer.0.pin.{k} => laps-{axis}.in1
#net COMMAND-{axis} => laps-{axis}.in0
#net TO-DRIVE-{axis} <= laps-{axis}.out
"""
