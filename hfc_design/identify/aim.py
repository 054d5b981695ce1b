"""The scenario that a design run takes: the machine as it was identified, within its tolerances.

Whoever has no scenario yet gets motions like those of the log, in the cycle of its samples, with a
fitness that asks for a small error at a calm command.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import tomli_w

from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.free import LATE, LOAD
from hfc_design.identify.recording import Recording
from hfc_design.logs.steps import noise_of

if TYPE_CHECKING:
    from hfc_design.identify.result import Identified

#: Least tolerance of a parameter that the log tells: friction is another one when it is warm.
#: The largest one, also of what the log does not tell.
LEAST, MOST = 0.05, 0.5
#: Tolerance of parameters that were not looked for, unless the scenario says it.
OTHERS = 0.1
#: A recorded velocity is a difference over some samples if it is off that by less than a share.
MOST_SAMPLES, ALIKE = 16, 1e-3
#: Digits of a parameter in a file, and of what stands around it.
DIGITS, FEW = 6, 4


def tolerances(found: "Identified") -> dict[str, float]:
    """Of each parameter half its interval as a share of its value, within bounds."""
    known, shares = found.known, {}
    each = zip(found.free.names, known.value, known.low, known.high, strict=True)
    for name, value, low, high in each:
        half = 0.5 * (high - low) / abs(value) if value else MOST
        share = float(np.clip(half if np.isfinite(half) else MOST, LEAST, MOST))
        shares[name] = float(f"{share:.2g}")
    return shares


def plant(found: "Identified") -> Json:
    """The machine as it was identified."""
    data: Json = found.scenario.plant.model_dump(mode="json", exclude_unset=True)
    each = zip(found.free.names, found.known.value, strict=True)
    own = found.free.start._fields
    value = {name: float(f"{x:.{DIGITS}g}") for name, x in each if name in own}
    if found.task.made and found.told.step and (name := finer(found)):
        value[name] = found.told.step
    if len(axes := found.scenario.plant.machine.axes) == 1:
        return {**data, "parameters": {**data.get("parameters", {}), **value}}
    name = axes[found.axis]
    every = data.get("axes", {})
    return {**data, "axes": {**every, name: {**every.get(name, {}), **value}}}


def finer(found: "Identified") -> str | None:
    """The parameter that is the step of the scale, where the log shows another one."""
    axis, seen = found.scenario.plant.each()[found.axis], found.free.drive.seen[0]
    name = axis.drive.resolutions.get(seen)
    return None if name in found.task.known or not axis.resolution else name


def delay(found: "Identified") -> tuple[float, float] | None:
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


def _around(found: "Identified", data: Json) -> None:
    """Into ``data`` what stands around the drive: delay, lag and load that were found or known."""
    axis = found.scenario.plant.each()[found.axis].name
    several = len(found.scenario.plant.machine.axes) > 1
    load = found.scenario.load.of(axis)
    value = _load(found)
    if value != load.constant or (found.task.made and value):
        own = load.model_dump(mode="json", exclude_defaults=True)
        own["constant"] = value
        told = {**data.get("load", {})}
        data["load"] = {**told, "axes": {**told.get("axes", {}), axis: own}} if several else own
    limits = {k: x for k, x in found.scenario.limits.of(axis) if k in LATE}
    late = dict(zip(LATE, delay(found) or (), strict=False))
    now = limits | {k: x for k, x in late.items() if k not in found.task.known}
    if changes := {k: x for k, x in now.items() if x != limits[k] or (found.task.made and x)}:
        part = data.setdefault("limits", {})
        part = part.setdefault("axes", {}).setdefault(axis, {}) if several else part
        part.update(changes)


def _load(found: "Identified") -> float:
    """What is always there; 0 where the log does not tell it from 0."""
    axis = found.scenario.plant.each()[found.axis].name
    if LOAD not in found.free.names:
        return found.scenario.load.of(axis).constant
    k = found.free.names.index(LOAD)
    none = found.known.low[k] <= 0.0 <= found.known.high[k]
    return 0.0 if none else float(f"{found.known.value[k]:.{DIGITS}g}")


def scenario_text(found: "Identified") -> str:
    """The scenario as TOML; motions and fitness are made unless there was a scenario.

    Raises:
        UserError: it is no scenario with these parameters.
    """
    made = found.task.made
    data = _made(found) if made else _own(found)
    data["plant"] = plant(found)
    _around(found, data)
    if "stress" in Scenario.model_fields and (seen := found.response):
        modes = {"far_modes_hz": [seen.mode]} if seen.mode else {}
        above = {"unknown_above_hz": seen.unknown_above}
        data["stress"] = {**(data.get("stress") or {}), **modes, **above}
    robust = data.get("robust", {"spread": OTHERS, "first": 8, "machines": 8, "elite": 8})
    # Of load, delay and lag what stress tries is wider than what a log leaves open.
    own = found.free.start._fields
    within = {name: x for name, x in tolerances(found).items() if name in own}
    data["robust"] = {**robust, "tolerances": {**robust.get("tolerances", {}), **within}}
    told = {"name": called(found.log), "description": f"{found.scenario.plant.name} by its log"}
    data = {**told, **data}
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


def _own(found: "Identified") -> Json:
    data: Json = found.scenario.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    return {key: value for key, value in data.items() if key not in ("name", "description")}


def _made(found: "Identified") -> Json:
    """Motions like those of the log."""
    told, scenario = found.told, found.scenario
    axis = scenario.plant.each()[found.axis]
    speed, acceleration = _fastest(told)
    distance, limit = float(np.ptp(told.place)), _limit(found)
    rate = scenario.limits.of(axis.name).command_rate
    lasts = distance / speed + speed / acceleration
    error = _recorded_error(told) or 1e-3 * distance
    step = told.step or axis.resolution or 0.0  # nobody sees what is less
    data: Json = {
        "plant": {"name": scenario.plant.name},
        "simulation": {
            "duration_s": _duration(lasts),
            "sample_time_s": float(f"{told.sample_time:.9g}"),
            "substeps": scenario.simulation.substeps,
        },
        "limits": {"command": limit, **({"command_rate": rate} if rate else {})},
        "sensors": {"velocity": "encoder", **differences(told, found.free.drive.seen[1])},
        "motions": _motions(told, speed, acceleration, lasts),
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
            "linear": {},
        },
        "search": {"preset": "cma"},
    }
    if told.step and not axis.resolution:
        data["sensors"]["encoder_resolution"] = told.step
    off = found.found.fit.residual[:, 0]
    if noise := noise_of(off, told.place, told.step or axis.resolution):
        data["sensors"]["noise"] = noise
    return data


def differences(told: Recording, rate: str) -> Json:
    """Over how many samples the control takes its velocity, where the log has that too."""
    if rate not in told.outputs:
        return {}
    off = {}
    for samples in range(1, MOST_SAMPLES + 1):
        slope = (told.place[samples:] - told.place[:-samples]) / (samples * told.sample_time)
        off[samples] = float(np.std(told.outputs[rate][samples:] - slope))
    best = min(off, key=off.__getitem__)
    is_one = best > 1 and off[best] < ALIKE * np.std(told.outputs[rate])
    return {"difference_samples": best} if is_one else {}


def _duration(lasts: float) -> float:
    """Of every motion, for a move that ``lasts`` so long [s]."""
    return round(1.5 * lasts + 0.5, 2)


def _motions(told: Recording, speed: float, acceleration: float, lasts: float) -> list[Json]:
    """A move as far as that of the log, a slow one, and one to and fro."""
    distance, slow = float(np.ptp(told.place)), 0.05 * speed
    # Two periods, so that it reverses at the end too; no faster than the log.
    often = min(4.0 * np.pi / _duration(lasts), 5.0 * acceleration / speed)
    move = _rounded(
        kind="trapezoidal", distance=distance, velocity=speed, acceleration=acceleration
    )
    sine = _rounded(kind="sine", amplitude=0.2 * speed / often, frequency_rad_s=often)
    return [
        {"name": "move", "reference": move, "settled_after_s": round(1.2 * lasts + 0.2, 2)},
        {"name": "slow", "reference": _rounded(kind="ramp", velocity=slow)},
        {"name": "reversal", "reference": sine},
    ]


def _rounded(**reference: Any) -> Json:
    return {key: float(f"{x:.3g}") if isinstance(x, float) else x for key, x in reference.items()}


def _fastest(told: Recording) -> tuple[float, float]:
    """Speed and acceleration that the log reaches, but for its noise."""
    place = told.place if told.reference is None else told.reference
    width = max(min(round(0.01 / told.sample_time), len(place) // 8), 1)
    smooth = np.convolve(place, np.ones(width) / width, "valid")
    rate = (smooth[width:] - smooth[:-width]) / (width * told.sample_time)
    change = (rate[width:] - rate[:-width]) / (width * told.sample_time)
    speed = max(float(np.quantile(np.abs(rate), 0.99)), float(np.ptp(place)) / told.duration)
    return speed, max(float(np.quantile(np.abs(change), 0.99)), speed)


def _limit(found: "Identified") -> float:
    """The largest command of the drive, or, where it has no limit, of the log."""
    axis = found.scenario.plant.each()[found.axis]
    low, high = axis.drive.largest_commands(axis.parameters, found.scenario.limits.command)
    largest = min(-low, high)
    if np.isfinite(largest):
        return float(largest)
    command = found.told.command
    return float(f"{np.abs(command).max():.2g}") if command is not None else 1.0


def _recorded_error(told: Recording) -> float | None:
    """What the loop that recorded the log was off its reference (rms)."""
    if told.reference is None:
        return None
    return float(np.sqrt(np.mean((told.reference - told.place) ** 2))) or None


def called(log: str) -> str:
    """What a scenario is called, and the folder, that a log is made into."""
    stem = re.sub(r"[^A-Za-z0-9_-]+", "-", Path(log).stem)[:60].strip("-") or "log"
    return f"{stem}-identified"
