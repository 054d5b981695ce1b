"""Everything that a log tells of a machine."""

import json
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Json
from hfc_design.core.shown import line, table
from hfc_design.core.texts import toml_of
from hfc_design.files.machine import Axis
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.advice import Advice, Profile
from hfc_design.identify.aim import scenario_text, tolerances
from hfc_design.identify.certainty import CONFIDENCE, GIVEN, HELD, Certainty, Combination
from hfc_design.identify.fit import Found
from hfc_design.identify.free import Free, Task
from hfc_design.identify.recording import Recording
from hfc_design.identify.response import LAGS, Response
from hfc_design.pictures.numbers import readable
from hfc_design.pictures.section import Rows

HEADS = ["parameter", "unit", "began", "found", "from", "to", "told?"]
CHECKED = ["log", "replayed in", "rms before", "rms after"]


class Check(NamedTuple):
    """A log replayed with the parameters that were found, or with those of the start."""

    log: str
    how: str  # under the recorded command, or in closed loop
    before: float  # rms residual with the parameters of the start [unit of the position]
    after: float
    residual: Floats  # (steps,) recorded less simulated


class Identified(NamedTuple):
    """Everything that a log tells, in words, tables and numbers."""

    log: str  # its name
    task: Task
    found: Found
    known: Certainty
    states: tuple[str, ...]  # of each parameter, see ``Kept``
    profiles: tuple[Profile, ...]
    checks: tuple[Check, ...]
    advice: Advice | None
    response: Response | None
    told: Recording
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        told: dict[str, object] = {"log": self.log, "plant": self.free.drive.name}
        told |= zip(self.free.names, map(float, self.known.value), strict=True)
        return line("Identified", told)

    def _repr_html_(self) -> str:
        rows: dict[str, object] = {}
        for name, unit, _, value, low, high, state in parameter_rows(self):
            how = f"{low} to {high}" if state in ("yes", GIVEN) else state
            rows[f"{name} [{unit or 1}]"] = f"{value} ({how})"
        for log, how, before, after in check_rows(self):
            rows[f"{log}, {how}"] = f"{after} off (rms), {before} before"
        return table(f"{self.free.drive.name} by {self.log}", rows)

    def numbers(self) -> Json:
        """What ``identified.json`` holds: each parameter with its interval, what is left.

        A number that is none is None.
        """
        known, free = self.known, self.free
        parameters: Json = {
            name: {
                "value": float(known.value[k]),
                "low": float(known.low[k]),
                "high": float(known.high[k]),
                "told": self.states[k],
                "began": free.starts[name],
                "tolerance": tolerances(self)[name],
                "unit": free.unit(name),
            }
            for k, name in enumerate(free.names)
        }
        late = self.told.sample_time * np.array([self.found.fit.late, *known.late])
        own = self.response
        check = own and {
            "mode_hz": own.mode,
            "unknown_above_hz": own.unknown_above,
            "coloured": own.coloured / LAGS,
            "coherence": np.stack([own.frequency, own.coherence], axis=1).tolist(),
        }
        data: Json = {
            "format": "hfc-design-identified",
            "version": 1,
            "log": self.log,
            "plant": free.drive.name,
            "confidence": CONFIDENCE,
            "parameters": parameters,
            "command_late_s": dict(zip(("value", "low", "high"), map(float, late), strict=True)),
            "replayed_under": self.found.how,
            "position_unit": self.position_unit,
            "rms": dict(zip(self.told.outputs, map(float, self.found.fit.rms), strict=True)),
            "checks": [
                {"log": one.log, "how": one.how, "rms_before": one.before, "rms": one.after}
                for one in self.checks
            ],
            "lag_s": self.told.sample_time * self.found.fit.lag,
            "model_check": check,
            "untold": untold_lines(self),
            "record_next": advice_line(self),
            "notes": list(self.notes),
        }
        told: Json = json.loads(json.dumps(data), parse_constant=lambda _: None)
        return told

    def for_design(self) -> Scenario:
        """The scenario for a search: the machine as it was found, within its tolerances.

        Raises:
            UserError: it is no scenario with these parameters.
        """
        return load_scenario(toml_of(scenario_text(self)))

    @property
    def axis(self) -> Axis:
        """The one of the machine, as the fit began."""
        return self.task.scenario.plant.each()[self.task.axis]

    @property
    def free(self) -> Free:
        """The parameters that were looked for."""
        return self.found.fit.free

    @property
    def position_unit(self) -> str:
        """Of the residual."""
        return self.free.drive.units["error"]


def parameter_rows(found: Identified) -> Rows:
    """Of each parameter its value and the ends of its interval."""
    known, free = found.known, found.free
    rows = []
    for k, name in enumerate(free.names):
        start = free.starts[name]
        numbers = [f"{x:.5g}" for x in (start, known.value[k])]
        told = known.error[k] < 2.0 and found.states[k] != HELD
        ends = [f"{x:.5g}" if told else "–" for x in (known.low[k], known.high[k])]
        rows.append([name, free.unit(name), *numbers, *ends, found.states[k]])
    return rows


def interval_line(found: Identified) -> str:
    """What the ends of the intervals mean."""
    line = f"from and to are the ends of the {100 * CONFIDENCE:g} % interval, if the model is right"
    each = zip(found.free.names, found.states, strict=True)
    held = ", ".join(name for name, state in each if state == HELD)
    return f"{line}; where 'given', if what is held ({held}) is right" if held else line


def check_rows(found: Identified) -> Rows:
    """Of each replay what it is off, before and after."""
    rows = []
    for check in found.checks:
        cells = [_read(found, x) for x in (check.before, check.after)]
        rows.append([check.log, check.how, *cells])
    return rows


#: So many combinations are told that the log does not tell, and parameters of each.
COMBINATIONS, TOGETHER = 4, 3
ALIKE = (
    "changed together like this the machine does the same under a command, if not under an outer "
    "force: what is given is known beside what is held, and a design needs no wider tolerance"
)


def untold_lines(found: Identified) -> list[str]:
    """What the log does not tell, in words."""
    lines = [_untold(one) for one in found.known.untold[:COMBINATIONS]]
    if len(found.known.untold) > COMBINATIONS:
        more = len(found.known.untold) - COMBINATIONS
        lines.append(f"and {more} more such combinations: look for fewer parameters")
    if lines and GIVEN in found.states:
        lines.append(ALIKE)
    return lines


def _untold(one: Combination) -> str:
    change = f"{100 * one.change:.2g} %" if one.change < 10.0 else f"a factor of {one.change:.2g}"
    (first, _), *others = sorted(one.shares.items(), key=lambda item: -abs(round(item[1], 9)))
    if not others:
        return f"{first} is only known to {change}"
    rest = f" and {len(others) - TOGETHER} more" if len(others) > TOGETHER else ""
    shown = others[:TOGETHER]
    told = ", ".join(f"{name} ({100 * one.change * x:+.2g} %)" for name, x in shown)
    return f"{first} may change by {change} if others do too: {told}{rest}"


def response_lines(found: Response | None) -> list[str]:
    """What the frequencies of the log say against the model."""
    if found is None:
        return []
    if found.top is None:
        return [UNEXCITED]
    lines = [
        f"nothing above {found.unknown_above:g} Hz was excited; a mode there cannot be excluded: "
        "design for one, or record faster motions"
    ]
    if found.top > ALL * found.frequency[-1]:
        lines = []
    if found.mode:
        lines.append(f"there is a mode near {found.mode:g} Hz that this model has not")
    white = "is white" if found.coloured <= WHITE * LAGS else "is not white, the model lacks it"
    told = f"{found.coloured} of {LAGS} autocorrelations are none of white noise"
    return [*lines, f"what is left {white}: {told}"]


UNEXCITED = (
    "DOUBTFUL: the log has no excitation: at no frequency the position answers the command above "
    "its noise; record reversals and faster motions"
)
#: Above this share of the highest frequency of a log there is nothing; of white noise so many
#: autocorrelations may be off.
ALL, WHITE = 0.8, 0.15
NOTHING = (
    "no sine of the command would tell much more; measure other signals too, as the current, or "
    "look for fewer parameters"
)


def advice_line(found: Identified) -> str:
    """What to record next; "" if there is nothing to say."""
    one = found.advice
    if one is None:
        untold = not all(found.known.told)
        return NOTHING if untold else ""
    units = found.free.drive.units
    gains = ", ".join(
        f"{name} from ±{100 * a:.2g} % to ±{100 * b:.2g} %" for name, (a, b) in one.errors.items()
    )
    factor, small = readable(found.position_unit, one.travel)
    return (
        f"{one.duration:g} s of a sine of the command of {one.amplitude:.3g} {units['command']} at "
        f"{one.frequency:g} Hz (the axis goes {factor * one.travel:.3g} {small} to and fro, at up "
        f"to {one.speed:.3g} {units['error_rate']}) would tell {gains} (standard errors)"
    )


def verdict(found: Identified) -> str:
    """What came out, in a sentence."""
    told, one = found.known.told, found.checks[0]
    count = f"{sum(told) or 'none'} of {len(told)} parameters that were looked for"
    before, after = (_read(found, x) for x in (one.before, one.after))
    return (
        f"the log tells {count}, and the replay is {after} off (rms); it was {before} with the "
        "values that it began with"
    )


def _read(found: Identified, position: float) -> str:
    """A position with a unit that it is easy to read in."""
    factor, unit = readable(found.position_unit, position)
    return f"{factor * position:.3g} {unit}"


def agreeing_line(found: Identified) -> str:
    """How far the starts agree."""
    return (
        f"{found.found.fit.agreeing} of the ten best of a hundred starts end at the same residual; "
        f"replayed under: {found.found.how}"
    )
