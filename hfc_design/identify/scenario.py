"""The scenario of a search for an identified machine.

It contains the identified machine with its tolerances. If the user gave no scenario and no design,
it also has motions like those of the log, the sample time of the log, and a fitness that requires a
small error and a calm command.
"""

import re
from pathlib import Path

import numpy as np
import tomli_w

from hfc_design.core.numbers import Json, rms
from hfc_design.core.overrides import overridden
from hfc_design.core.records import UserError
from hfc_design.files.machine import unmoved
from hfc_design.files.motions import LEAST_STEPS
from hfc_design.files.named_scenario import load_scenario
from hfc_design.identify.outcome import LEAST, MOST, Outcome
from hfc_design.identify.parameters import LATE, LOAD
from hfc_design.identify.recording import Recording
from hfc_design.logs.sensors import noise_level
from plants import Drive

#: Tolerance of parameters that were not identified, unless the scenario sets it.
OTHERS = 0.1
#: ``[robust]`` of a search with many candidates on few machines; ``[constraints]`` for its loops.
FEW_MACHINES: Json = {"margin": 1.3, "first": 3, "machines": 3, "elite": 3}
ASKED: Json = {"unsettled": 0.3, "sensitivity": 2.0, "delay_margin_samples": 1.5}
#: Most samples over which a velocity is a difference; relative deviation up to which it is one.
MOST_SAMPLES, SAME_RATE = 16, 1e-3
#: Digits of parameters in the file, and of delay and lag.
DIGITS, FEW = 6, 4
#: Height of the step motion as a multiple of the rms error during the recording.
STEP = 3.0


def _rounded(value: float, digits: int) -> float:
    """Return a number with so many significant digits."""
    return float(f"{value:.{digits}g}")


def delay(outcome: Outcome) -> tuple[float, float] | None:
    """Return delay [samples] and lag [s] for ``limits``; None: they were not identified.

    Both are 0 if the interval of the delay includes 0, or if the command acts too early.
    """
    fit, (low, high) = outcome.fit, outcome.known.late
    if low == high:
        return None
    if low <= 0.0:
        return 0.0, 0.0
    lag = min(fit.lag, fit.late)
    return _rounded(fit.late - lag, FEW), _rounded(lag * outcome.recording.sample_time, FEW)


def machine(outcome: Outcome) -> Json:
    """Return parameters, load, delay and lag as identified, by dotted keys of a scenario."""
    free, axis = outcome.free, outcome.axis
    scenario, made, known = outcome.task.scenario, outcome.task.made, outcome.task.known
    several = f".axes.{axis.name}" if len(scenario.plant.machine.axes) > 1 else ""
    drive = f"plant{several or '.parameters'}"
    load, limits = scenario.load.of(axis.name), scenario.limits.of(axis.name)
    pairs = zip(free.names, outcome.known.value, strict=True)
    values, constant = {name: _rounded(x, DIGITS) for name, x in pairs}, load.constant
    if LOAD in values.keys() - {*free.start._fields}:
        k, constant = free.names.index(LOAD), values.pop(LOAD)
        if outcome.known.low[k] <= 0.0 <= outcome.known.high[k]:
            constant = 0.0  # the interval includes 0
    step = axis.drive.resolutions.get(free.drive.seen[0])
    if made and outcome.recording.step and axis.resolution and step and step not in known:
        values[step] = outcome.recording.step  # of the encoder, as the log shows it
    changes: Json = {f"{drive}.{name}": x for name, x in values.items()}
    if constant != load.constant or (made and constant):
        other = load.model_dump(mode="json", exclude_defaults=True)
        changes[f"load{several}"] = {**other, "constant": constant}
    late = dict(zip(LATE, delay(outcome) or (), strict=False))
    for name in LATE:
        now = getattr(limits, name)
        value = now if name in known else late.get(name, now)
        if value != now or (made and value):
            changes[f"limits{several}.{name}"] = value
    return changes


def scenario_text(outcome: Outcome) -> str:
    """Return the scenario as TOML; motions and fitness are generated if the user gave none.

    Raises:
        UserError: the parameters do not give a valid scenario.
    """
    scenario, made = outcome.task.scenario, outcome.task.made
    given: Json = scenario.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    if made:
        given = {x: given[x] for x in ("plant", "stress") if x in given} | _like_the_log(outcome)
    data = overridden(given, machine(outcome))
    if response := outcome.response:
        modes = {"modes": [response.mode.model_dump()]} if response.mode else {}
        above = {"unknown_above_hz": response.unknown_above}
        data["stress"] = {**data.get("stress", {}), **modes, **above}
    robust = data.get("robust", {"spread": OTHERS, **FEW_MACHINES})
    # Load, delay and lag need no tolerance: stress varies them by more than a log leaves open.
    within = {
        x: share for x, share in outcome.tolerances.items() if x in outcome.free.start._fields
    }
    data["robust"] = {**robust, "tolerances": {**robust.get("tolerances", {}), **within}}
    names = {
        "name": scenario_name(outcome.log),
        "description": f"{scenario.plant.name} identified from its log",
    }
    data = names | data | names  # first in the file, and in place of those of a given scenario
    notes = []
    try:
        load_scenario(data)
    except UserError as error:
        if made:
            raise
        del data["robust"]  # perhaps the given fitness cannot rank several machines
        notes = [f"# Without [robust]: {error.lines[0]}"]
        load_scenario(data)
    head = ["# The machine as identified from its log; tolerances are half of the 95 % intervals,"]
    head += [f"# at least {100 * LEAST:g} % and at most {100 * MOST:g} %.", *notes]
    return "\n".join(head) + "\n" + tomli_w.dumps(data)


def _like_the_log(outcome: Outcome) -> Json:
    """Return all tables except that of the plant, with motions like those of the log."""
    log, scenario, axis = outcome.recording, outcome.task.scenario, outcome.axis
    speed, acceleration = fastest(log)
    distance = float(np.ptp(log.place))
    low, high = axis.drive.largest_commands(axis.parameters, scenario.limits.command)
    limit = float(min(-low, high))
    if not np.isfinite(limit):  # then take the largest command of the log
        limit = 1.0 if log.command is None else _rounded(np.abs(log.command).max(), 2)
    rate = scenario.limits.of(axis.name).command_rate
    duration = round(1.5 * (distance / speed + speed / acceleration) + 0.5, 2)
    behind = 0.0 if log.reference is None else rms(log.reference - log.place)
    error = behind or 1e-3 * distance  # of the loop that recorded the log (rms)
    step = log.step or axis.resolution or 0.0  # the encoder does not show smaller errors
    data: Json = {
        "simulation": {
            "duration_s": duration,
            "sample_time_s": _rounded(log.sample_time, 9),
            "substeps": scenario.simulation.substeps,
        },
        "limits": {"command": limit, **({"command_rate": rate} if rate else {})},
        "sensors": {
            "velocity": "encoder",
            **differences(log, outcome.free.drive.seen[1]),
            **scenario.sensors.of(axis.name).model_dump(include={"feedback"}, exclude_none=True),
        },
        "motions": motions_like(log, speed, acceleration, duration, error),
        "fitness": {
            "kind": "tolerances",
            "tolerances": {
                "rms_error": max(_rounded(0.1 * error, 2), step),
                "settled_rms_error": max(_rounded(0.02 * error, 2), step),
                "chatter": {"tolerance": _rounded(0.02 * limit, 2), "weight": 0.3},
            },
        },
        "controller": {
            "output_scale": 1.0,
            "schedules": True,
            "inputs": [
                {"name": "reference_rate", "scale": _rounded(40.0 / speed, 2)},
                {"name": "error", "scale": _rounded(1.0 / error, 2)},
            ],
            "linear": linear_part(outcome.free.drive, log),
        },
        "constraints": ASKED,
        "search": {"preset": "cma", "generations": 700, "hardened": 0.85},
    }
    if log.step and not axis.resolution:
        data["sensors"]["encoder_resolution"] = log.step
    off = outcome.fit.residual[:, 0]
    if noise := noise_level(off, log.place, log.step or axis.resolution):
        data["sensors"]["noise"] = noise
    return data


def fastest(log: Recording) -> tuple[float, float]:
    """Return the largest speed and acceleration of the log (99 % quantiles), without its noise."""
    place = log.place if log.reference is None else log.reference
    width = max(min(round(0.01 / log.sample_time), len(place) // 8), 1)
    smooth = np.convolve(place, np.ones(width) / width, "valid")
    rate = (smooth[width:] - smooth[:-width]) / (width * log.sample_time)
    change = (rate[width:] - rate[:-width]) / (width * log.sample_time)
    speed = max(float(np.quantile(np.abs(rate), 0.99)), float(np.ptp(place)) / log.duration)
    return speed, max(float(np.quantile(np.abs(change), 0.99)), speed)


def motions_like(
    log: Recording, speed: float, acceleration: float, duration: float, error: float
) -> list[Json]:
    """Return four motions: a move as far as the log, a slow ramp, a sine, and a step."""
    distance, slow = float(np.ptp(log.place)), 0.05 * speed
    lasts = distance / speed + speed / acceleration
    # Two periods, so that the sine reverses near the end too; no faster than the log.
    often = min(4.0 * np.pi / duration, 5.0 * acceleration / speed)
    move = _reference("trapezoidal", distance=distance, velocity=speed, acceleration=acceleration)
    sine = _reference("sine", amplitude=0.2 * speed / often, frequency_rad_s=often)
    step = _reference("step", height=max(STEP * error, LEAST_STEPS * (log.step or 0.0)))
    return [
        {"name": "move", "reference": move, "settled_after_s": round(1.2 * lasts + 0.2, 2)},
        {"name": "slow", "reference": _reference("ramp", velocity=slow)},
        {"name": "reversal", "reference": sine},
        {"name": "step", "reference": step, "settled_after_s": round(0.5 * duration, 2)},
    ]


def _reference(kind: str, **numbers: float) -> Json:
    return {"kind": kind, **{key: _rounded(x, 3) for key, x in numbers.items()}}


def linear_part(drive: Drive, log: Recording) -> Json:
    """Return settings of the linear part, so that it reads only encoders that the log has.

    An axis with feedback from the encoder of the motor may lack a scale.
    """
    missing = drive.encoders.keys() - {drive.seen[0]} - log.outputs.keys()
    if drive.seen[0] == drive.position or not missing:
        return {}
    return {"signals": sorted({*unmoved(drive, missing)} - {*drive.seen})}


def differences(log: Recording, rate: str) -> Json:
    """Return {"difference_samples": number} as the log's velocity shows it; {}: one, or unknown."""
    if rate not in log.outputs:
        return {}
    off = {}
    for samples in range(1, MOST_SAMPLES + 1):
        slope = (log.place[samples:] - log.place[:-samples]) / (samples * log.sample_time)
        off[samples] = float(np.std(log.outputs[rate][samples:] - slope))
    best = min(off, key=off.__getitem__)
    is_one = best > 1 and off[best] < SAME_RATE * np.std(log.outputs[rate])
    return {"difference_samples": best} if is_one else {}


def scenario_name(log: str) -> str:
    """Return the name of the scenario, and of the folder, that are made from a log."""
    stem = re.sub(r"[^A-Za-z0-9_-]+", "-", Path(log).stem)[:60].strip("-") or "log"
    return f"{stem}-identified"
