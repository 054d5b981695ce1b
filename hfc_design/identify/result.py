"""Everything that a log tells of a machine, in words and numbers, and the scenario of a search.

That has the machine as it was identified, within its tolerances. Whoever has no scenario yet gets
motions like those of the log, in the cycle of its samples, with a fitness that asks for a small
error at a calm command.
"""

import json
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tomli_w

from hfc_design.core.dotted import changed
from hfc_design.core.numbers import Floats, Json
from hfc_design.core.records import UserError
from hfc_design.core.shown import line, table
from hfc_design.core.texts import toml_of
from hfc_design.core.wording import percent
from hfc_design.files.machine import Axis, unmoved
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.advice import Advice, Profile
from hfc_design.identify.certainty import CONFIDENCE, GIVEN, HELD, Certainty, Combination
from hfc_design.identify.fit import Found
from hfc_design.identify.free import LATE, LOAD, Free, Task
from hfc_design.identify.motions_like import fastest, motions_like
from hfc_design.identify.replay import Recording
from hfc_design.identify.response import LAGS, Response
from hfc_design.logs.sensors import noise_of
from hfc_design.pictures.numbers import readable
from hfc_design.pictures.section import Rows
from plants import Drive

HEADS = ["parameter", "unit", "began", "found", "from", "to", "told?"]
CHECKED = ["log", "replayed in", "rms before", "rms after"]
#: Least tolerance of a parameter that the log tells: friction is another one when it is warm.
#: The largest one, also of what the log does not tell.
LEAST, MOST = 0.05, 0.5
#: Tolerance of parameters that were not looked for, unless the scenario says it.
OTHERS = 0.1
#: Of a search of many individuals on few machines, and what its loops have to be.
FEW_MACHINES: Json = {"margin": 1.3, "first": 3, "machines": 3, "elite": 3}
ASKED: Json = {"unsettled": 0.3, "sensitivity": 2.0, "delay_margin_samples": 1.5}
#: A recorded velocity is a difference over some samples if it is off that by less than a share.
MOST_SAMPLES, SAME_RATE = 16, 1e-3
#: Digits of a parameter in a file, and of what stands around it.
DIGITS, FEW = 6, 4


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
            "mode": own.mode and own.mode.model_dump(),
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
        return self.task.one

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
    change = percent(one.change) if one.change < 10.0 else f"a factor of {one.change:.2g}"
    (first, _), *others = sorted(one.shares.items(), key=lambda item: -abs(round(item[1], 9)))
    if not others:
        return f"{first} is only known to {change}"
    rest = f" and {len(others) - TOGETHER} more" if len(others) > TOGETHER else ""
    shown = others[:TOGETHER]
    told = ", ".join(f"{name} ({100 * one.change * x:+.3g} %)" for name, x in shown)
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
        lines.append(f"there is a mode near {found.mode.hz:g} Hz that this model has not")
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
        f"{name} to {percent(b)} (now to {percent(a)})" for name, (a, b) in one.errors.items()
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


def tolerances(found: Identified) -> dict[str, float]:
    """Of each parameter half its interval as a share of its value, within bounds."""
    known, shares = found.known, {}
    each = zip(found.free.names, known.value, known.low, known.high, strict=True)
    for name, value, low, high in each:
        half = 0.5 * (high - low) / abs(value) if value else MOST
        share = float(np.clip(half if np.isfinite(half) else MOST, LEAST, MOST))
        shares[name] = float(f"{share:.2g}")
    return shares


def delay(found: Identified) -> tuple[float, float] | None:
    """What ``limits`` have: the delay [samples], and the lag [s]; None: nobody looked for them.

    A command that acts earlier than its samples say has none.
    """
    fit, (low, high) = found.found.fit, found.known.late
    if low == high:
        return None
    if low <= 0.0:
        return 0.0, 0.0
    lag = min(fit.lag, fit.late)
    return float(f"{fit.late - lag:.{FEW}g}"), float(f"{lag * found.told.sample_time:.{FEW}g}")


def machine(found: Identified) -> Json:
    """The drive and what stands around it as they were identified, by dotted keys of a scenario."""
    scenario, made, known = found.task.scenario, found.task.made, found.task.known
    axis, names = found.axis, scenario.plant.machine.axes
    several = f".axes.{axis.name}" if len(names) > 1 else ""
    drive = f"plant{several or '.parameters'}"
    load, limits = scenario.load.of(axis.name), scenario.limits.of(axis.name)
    each = zip(found.free.names, found.known.value, strict=True)
    own, constant = {name: float(f"{x:.{DIGITS}g}") for name, x in each}, load.constant
    if LOAD in own.keys() - {*found.free.start._fields}:
        k, constant = found.free.names.index(LOAD), own.pop(LOAD)
        if found.known.low[k] <= 0.0 <= found.known.high[k]:
            constant = 0.0  # the log does not tell it from none
    step = axis.drive.resolutions.get(found.free.drive.seen[0])
    if made and found.told.step and axis.resolution and step and step not in known:
        own[step] = found.told.step  # of the scale, where the log shows another one
    changes: Json = {f"{drive}.{name}": x for name, x in own.items()}
    if constant != load.constant or (made and constant):
        told = load.model_dump(mode="json", exclude_defaults=True)
        changes[f"load{several}"] = {**told, "constant": constant}
    late = dict(zip(LATE, delay(found) or (), strict=False))
    for name in LATE:
        now = getattr(limits, name)
        value = now if name in known else late.get(name, now)
        if value != now or (made and value):
            changes[f"limits{several}.{name}"] = value
    return changes


def scenario_text(found: Identified) -> str:
    """The scenario as TOML; motions and fitness are made unless there was a scenario.

    Raises:
        UserError: it is no scenario with these parameters.
    """
    made = found.task.made
    told: Json = found.task.scenario.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    kept = {name: told[name] for name in ("plant", "stress") if name in told}
    data = changed(kept | _made(found) if made else told, machine(found))
    if seen := found.response:
        modes = {"modes": [seen.mode.model_dump()]} if seen.mode else {}
        above = {"unknown_above_hz": seen.unknown_above}
        data["stress"] = {**data.get("stress", {}), **modes, **above}
    robust = data.get("robust", {"spread": OTHERS, **FEW_MACHINES})
    # Of load, delay and lag what stress tries is wider than what a log leaves open.
    own = found.free.start._fields
    within = {name: x for name, x in tolerances(found).items() if name in own}
    data["robust"] = {**robust, "tolerances": {**robust.get("tolerances", {}), **within}}
    names = {
        "name": called(found.log),
        "description": f"{found.task.scenario.plant.name} by its log",
    }
    data = names | data | names  # they stand first, and those of another scenario do not stay
    notes = []
    try:
        load_scenario(data)
    except UserError as error:
        if made:
            raise
        del data["robust"]  # its fitness ranks one machine alone
        notes = [f"# Without [robust]: {error.lines[0]}"]
        load_scenario(data)
    head = ["# What the machine is by its log; tolerances are halves of the 95 % intervals,"]
    head += [f"# at least {100 * LEAST:g} % and at most {100 * MOST:g} %.", *notes]
    return "\n".join(head) + "\n" + tomli_w.dumps(data)


def _made(found: Identified) -> Json:
    """Motions like those of the log."""
    told, scenario, axis = found.told, found.task.scenario, found.axis
    speed, acceleration = fastest(told)
    distance = float(np.ptp(told.place))
    low, high = axis.drive.largest_commands(axis.parameters, scenario.limits.command)
    limit = float(min(-low, high))
    if not np.isfinite(limit):  # then that of the log
        limit = 1.0 if told.command is None else float(f"{np.abs(told.command).max():.2g}")
    rate = scenario.limits.of(axis.name).command_rate
    lasts = distance / speed + speed / acceleration  # of a move [s]
    duration = round(1.5 * lasts + 0.5, 2)
    behind = 0.0 if told.reference is None else np.sqrt(np.mean((told.reference - told.place) ** 2))
    error = float(behind) or 1e-3 * distance  # of the loop that recorded the log (rms)
    step = told.step or axis.resolution or 0.0  # nobody sees what is less
    data: Json = {
        "simulation": {
            "duration_s": duration,
            "sample_time_s": float(f"{told.sample_time:.9g}"),
            "substeps": scenario.simulation.substeps,
        },
        "limits": {"command": limit, **({"command_rate": rate} if rate else {})},
        "sensors": {
            "velocity": "encoder",
            **differences(told, found.free.drive.seen[1]),
            **scenario.sensors.of(axis.name).model_dump(include={"feedback"}, exclude_none=True),
        },
        "motions": motions_like(told, speed, acceleration, duration, error),
        "fitness": {
            "kind": "tolerances",
            "tolerances": {
                "rms_error": max(float(f"{0.1 * error:.2g}"), step),
                "settled_rms_error": max(float(f"{0.02 * error:.2g}"), step),
                "chatter": {"tolerance": float(f"{0.02 * limit:.2g}"), "weight": 0.3},
            },
        },
        "controller": {
            "output_scale": 1.0,
            "schedules": True,
            "inputs": [
                {"name": "reference_rate", "scale": float(f"{40.0 / speed:.2g}")},
                {"name": "error", "scale": float(f"{1.0 / error:.2g}")},
            ],
            "linear": _linear(found.free.drive, told),
        },
        "constraints": ASKED,
        "search": {"preset": "cma", "generations": 700, "hardened": 0.85},
    }
    if told.step and not axis.resolution:
        data["sensors"]["encoder_resolution"] = told.step
    off = found.found.fit.residual[:, 0]
    if noise := noise_of(off, told.place, told.step or axis.resolution):
        data["sensors"]["noise"] = noise
    return data


def _linear(drive: Drive, told: Recording) -> Json:
    """A linear part, which reads no encoder that the log shows nothing of.

    An axis whose motor's encoder is fed back need not have a scale.
    """
    missing = drive.encoders.keys() - {drive.seen[0]} - told.outputs.keys()
    if drive.seen[0] == drive.position or not missing:
        return {}
    return {"signals": sorted({*unmoved(drive, missing)} - {*drive.seen})}


def differences(told: Recording, rate: str) -> Json:
    """Over how many samples the control takes its velocity, where the log has that too."""
    if rate not in told.outputs:
        return {}
    off = {}
    for samples in range(1, MOST_SAMPLES + 1):
        slope = (told.place[samples:] - told.place[:-samples]) / (samples * told.sample_time)
        off[samples] = float(np.std(told.outputs[rate][samples:] - slope))
    best = min(off, key=off.__getitem__)
    is_one = best > 1 and off[best] < SAME_RATE * np.std(told.outputs[rate])
    return {"difference_samples": best} if is_one else {}


def called(log: str) -> str:
    """What a scenario is called, and the folder, that a log is made into."""
    stem = re.sub(r"[^A-Za-z0-9_-]+", "-", Path(log).stem)[:60].strip("-") or "log"
    return f"{stem}-identified"
