"""Result of an identification, in numbers, tables and sentences."""

from typing import NamedTuple, cast

import numpy as np

from hfc_design.core.numbers import Floats, Json, storable
from hfc_design.core.tables import MISSING, Table, line
from hfc_design.files.machine import Axis
from hfc_design.identify.fit import Fit
from hfc_design.identify.identifiability import CONFIDENCE, GIVEN, HELD, Certainty
from hfc_design.identify.parameters import FreeParameters
from hfc_design.identify.profiles import Profile
from hfc_design.identify.recording import Recording
from hfc_design.identify.request import Task
from hfc_design.identify.response import LAGS, Response
from hfc_design.plotting.numbers import readable

#: Least tolerance of a determined parameter, since friction changes with temperature.
#: Largest tolerance, also of undetermined parameters.
LEAST, MOST = 0.05, 0.5
#: Relative standard error up to which the ends of an interval are shown.
WIDEST = 2.0
#: Largest number of undetermined combinations that are shown.
COMBINATIONS = 4
CHECKED = (
    "Recorded minus replayed position, rms, with the start values and with the identified "
    "parameters."
)
ALIKE = (
    "changed together in this way, the machine responds the same to a command, though "
    "not to an external force: the given parameters are known relative to the fixed "
    "ones, and a design needs no wider tolerance"
)
RECORD = (
    "the motion that hfc experiment scenario.toml makes; if its page says that no motion tells a "
    "parameter, measure other signals too, such as the current, or identify fewer parameters"
)


class Check(NamedTuple):
    """Replay of a log with the identified parameters, and with the start parameters."""

    log: str
    how: str  # under the recorded command, or in closed loop
    before: float  # rms residual with the start parameters [unit of the position]
    after: float  # rms residual with the identified parameters [unit of the position]
    residual: Floats  # (steps,) recorded less simulated position, identified parameters


class Outcome(NamedTuple):
    """Result of an identification, with its checks and doubts."""

    log: str  # name of the log that was fitted
    task: Task
    fit: Fit
    known: Certainty
    profiles: tuple[Profile, ...]
    checks: tuple[Check, ...]
    response: Response | None
    recording: Recording
    notes: tuple[str, ...]

    @property
    def axis(self) -> Axis:
        """The identified axis of the machine, with the parameters at the start of the fit."""
        return self.task.drive_axis

    @property
    def free(self) -> FreeParameters:
        """The fitted parameters."""
        return self.fit.free

    @property
    def position_unit(self) -> str:
        """Unit of the position, and of its residual."""
        return self.free.drive.units["error"]

    @property
    def tolerances(self) -> dict[str, float]:
        """Half the interval of each parameter over its value, from ``LEAST`` to ``MOST``."""
        known = self.known
        with np.errstate(divide="ignore", invalid="ignore"):
            half = 0.5 * (known.high - known.low) / np.abs(known.value)
        shares = np.clip(np.where(np.isfinite(half), half, MOST), LEAST, MOST)
        return {name: float(f"{x:.2g}") for name, x in zip(self.free.names, shares, strict=True)}

    def readable(self, position: float) -> str:
        """Return a position as a text, in a unit that suits its size."""
        factor, unit = readable(self.position_unit, position)
        return f"{factor * position:.3g} {unit}"

    def tables(self) -> list[Table]:
        """Return two tables: parameters with their intervals, and the residual of each replay."""
        known, free = self.known, self.free
        columns = known.value, known.low, known.high, known.error, known.state
        rows = [
            [name, free.unit(name), f"{free.starts[name]:.5g}", f"{value:.5g}"]
            + [f"{x:.5g}" if error < WIDEST and state != HELD else MISSING for x in (low, high)]
            + [state]
            for name, value, low, high, error, state in zip(free.names, *columns, strict=True)
        ]
        head = ["parameter", "unit", "start", "found", "from", "to", "known?"]
        about = f"Parameters; {self.interval_line()}. The intervals allow for a coloured residual."
        readable = self.readable
        checks = [[x.log, x.how, readable(x.before), readable(x.after)] for x in self.checks]
        advice = [f"record next: {line}"] if (line := self.advice_line()) else []
        lines = [self.agreeing_line(), *self.untold_lines(), *self.notes, *advice]
        return [
            Table(about, head, rows),
            Table(CHECKED, ["log", "replayed in", "before", "after"], checks, lines=lines),
        ]

    def interval_line(self) -> str:
        """Return a line that explains the ends of the intervals."""
        share = f"{100 * CONFIDENCE:g} %"
        line = f"from and to are the ends of the {share} interval, if the model is correct"
        states = zip(self.free.names, self.known.state, strict=True)
        fixed = ", ".join(name for name, state in states if state == HELD)
        given = f"; where 'given', if the fixed parameters ({fixed}) are correct"
        return line + given * bool(fixed)

    def untold_lines(self) -> list[str]:
        """Return lines on combinations of parameters that the log does not determine."""
        lines = [one.line() for one in self.known.untold[:COMBINATIONS]]
        if (more := len(self.known.untold) - COMBINATIONS) > 0:
            lines.append(f"and {more} more such combinations: identify fewer parameters")
        if lines and GIVEN in self.known.state:
            lines.append(ALIKE)
        return lines

    def advice_line(self) -> str:
        """Return a line on what to record next; "" if the log determines all parameters."""
        return "" if self.known.identifiable.all() else RECORD

    def verdict(self) -> str:
        """Return the result in a sentence."""
        identifiable, check = self.known.identifiable, self.checks[0]
        return (
            f"the log determines {sum(identifiable) or 'none'} of {len(identifiable)} parameters; "
            f"the replay deviates by {self.readable(check.after)} (rms), "
            f"{self.readable(check.before)} with the start values"
        )

    def agreeing_line(self) -> str:
        """Return a line that says how many starts reached the same residual."""
        return (
            f"{self.fit.agreeing} of the ten best of a hundred starts reach the same "
            f"residual; replayed with: {self.fit.how}"
        )

    def __repr__(self) -> str:
        values: dict[str, object] = {"log": self.log, "plant": self.free.drive.name}
        values |= zip(self.free.names, map(float, self.known.value), strict=True)
        return line("Identified", values)

    def _repr_html_(self) -> str:
        return "".join(one._repr_html_() for one in self.tables())

    def numbers(self) -> Json:
        """Return the content of ``identified.json``: parameters with intervals, and residuals.

        A number that is not finite is None.
        """
        known, free, fit, response = self.known, self.free, self.fit, self.response
        every = self.recording.sample_time
        parameters: Json = {
            name: {
                "value": float(known.value[k]),
                "low": float(known.low[k]),
                "high": float(known.high[k]),
                "told": known.state[k],
                "began": free.starts[name],
                "tolerance": self.tolerances[name],
                "unit": free.unit(name),
            }
            for k, name in enumerate(free.names)
        }
        late = zip(("value", "low", "high"), (fit.late, *known.late), strict=True)
        data: Json = {
            "format": "hfc-design-identified",
            "version": 1,
            "log": self.log,
            "plant": free.drive.name,
            "confidence": CONFIDENCE,
            "parameters": parameters,
            "command_late_s": {end: float(every * samples) for end, samples in late},
            "replayed_under": fit.how,
            "position_unit": self.position_unit,
            "rms": dict(zip(self.recording.outputs, map(float, fit.rms), strict=True)),
            "checks": [
                {"log": x.log, "how": x.how, "rms_before": x.before, "rms": x.after}
                for x in self.checks
            ],
            "lag_s": every * fit.lag,
            "model_check": response
            and {
                "mode": response.mode and response.mode.model_dump(),
                "unknown_above_hz": response.unknown_above,
                "coloured": response.coloured / LAGS,
                "coherence": np.stack([response.frequency, response.coherence], axis=1).tolist(),
            },
            "untold": self.untold_lines(),
            "record_next": self.advice_line(),
            "notes": list(self.notes),
        }
        return cast(Json, storable(data))
