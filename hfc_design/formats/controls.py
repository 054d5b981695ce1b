"""Designs of kinds ``pid`` and ``pid+ff`` as parameters of controls that take no foreign law.

``controls.toml`` lists the controls. Their integrals contain the error of the present sample. A
cascade of P and PI with full feed-forward of the velocity is a PID with ``kd = Kp``,
``kp = Kp (Kv + 1/Tn)`` and ``ki = Kp Kv / Tn``.
"""

import json
import re
import tomllib
from collections.abc import Mapping
from functools import partial
from math import isnan, nan, pi, sqrt
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json, number_or_none
from hfc_design.core.records import UserError, option
from hfc_design.core.texts import as_user_error, json_of, read_text
from hfc_design.core.wording import one_of
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import machine, own_scenario
from hfc_design.files.machine import Axis, SensorSettings
from hfc_design.formats.deployment import readme
from hfc_design.formats.writing import Content, Format, rendered

CONTROLS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
#: Data of the motor: turns of the axis [mm or deg], torque for a command [N m], and for a current
#: [N m/A]; each quantity needs as many as its name's first part says, others the first two.
MOTOR, NEEDED = ("lead", "torque", "torque_constant"), {"radian": 1, "current": 3}
#: Feed-forward of a design, of which a control has some.
FORWARD = ("velocity", "acceleration", "coulomb", "load")
#: Largest pole at which the filter before kd counts as none.
UNFILTERED = 1e-6
#: Size [deg] of units of angles.
ANGLES = {"rad": 180.0 / pi, "deg": 1.0}
#: Axis -> name of a parameter -> value.
Values: TypeAlias = dict[str, dict[str, float]]


class Row(NamedTuple):
    """Parameter of a control, a row of ``controls.toml``."""

    name: str
    of: str  # name of its quantity
    factor: float  # on the quantity
    unit: str
    low: float
    high: float
    meaning: str
    source: str


class Gains(NamedTuple):
    """PID of a design whose integral contains the present error, in the units of the design."""

    p: float
    i: float
    d: float
    forward: dict[str, float] = dict.fromkeys(FORWARD, 0.0)
    width: float = 1.0  # speed of the reference at which the Coulomb part is full


def parameters(
    name: str, design: Design, motor: Mapping[str, float] | None = None, old: str | Path = ""
) -> dict[str, Content]:
    """Return the files of a design for the control ``name``: values, lines to enter, README.

    ``motor`` has data of ``MOTOR`` that the plant does not have; ``old`` is a file with the values
    that are in the control now.

    Raises:
        UserError: the control lacks a part of the law, a datum is missing, a value is outside its
            range, or ``old`` is not valid.
    """
    control: Json = CONTROLS[name]
    rows = [Row(*row) for row in control["parameters"]]
    axes = _modes(design) if control["form"] == "modes" else _axes(control, design, motor or {})
    new: Values = {axis: _values(design, axis, rows, found) for axis, found in axes.items()}
    before = _old(control, Path(old), list(new), rows) if old else {}
    files: dict[str, Content] = {}
    for k, (stem, values) in enumerate({"parameters": new, "restore": before}.items()):
        if values:
            files[f"{stem}.json"] = json.dumps(values.get("", values), indent=1) + "\n"
            if "line" in control:
                files[control["files"][k]] = _lines(control, values, list(new))
    about = {"control": control, "rows": rows, "new": new, "old": before, "axes": axes}
    if control["form"] == "pid":
        files["pid.hal"] = rendered("controls/pid.hal.j2", design, **about)
    about |= {"files": list(files), "about": readme.origin(design), "kind": design.kind.name}
    return files | {"README.md": rendered("controls/README.md.j2", design, **about)}


def _modes(design: Design) -> dict[str, Json]:
    """Return frequency and damping of the modes in the design's scenario, for two axes."""
    modes = own_scenario(design, design.name).stress.modes
    if not 1 <= len(modes) <= 2:
        raise UserError(
            f"design {design.name}: stress.modes must be one or two, of X and Y (got {len(modes)}), "
            "as in [{ hz = 45, damping = 0.1 }]"
        )
    pairs = zip("xy", (modes * 2)[:2] if len(modes) == 1 else modes, strict=True)
    return {axis: {"mode_hz": one.hz, "mode_damping": one.damping} for axis, one in pairs}


def _axes(control: Json, design: Design, motor: Mapping[str, float]) -> dict[str, Json]:
    """Return the quantities of each axis by name, in mm or deg, s, N m; "" is the only axis."""
    for key in motor:
        if key not in MOTOR:
            raise UserError(f"{option('motor', motor[key], key=key)}: unknown; {one_of(key, MOTOR)}")
    scenario = own_scenario(design, design.name)
    plant, parts = machine(design, scenario), design.by_axis()
    found = {}
    for axis in plant.each():
        part, sensors = parts.get(axis.name, design), scenario.sensors.of(axis.name)
        gains = _gains(control, part, sensors)
        unit = axis.length or ANGLES.get(axis.drive.units["error"], 1.0)
        position = sensors.feedback or axis.drive.seen[0]
        seen = {"fed_position": position, "fed_velocity": ""}
        if sensors.velocity == "tachometer" and part.controller.kind == "pid+ff":
            seen["fed_velocity"] = axis.drive.encoders.get(position, axis.drive.velocity)
        quantities = {"zero": 0.0, "one": 1.0, **seen}
        if hasattr(axis.parameters, "backlash"):
            beyond = position != axis.drive.position  # the encoder sees no backlash behind it
            quantities["backlash"] = axis.parameters.backlash * unit * beyond
        if control["form"] == "pid":
            limit = part.limits.of(axis.name).command or 0.0
            quantities |= _pid(gains, unit) | {"limit": limit, "kind": part.controller.kind}
        else:
            quantities |= _cascade(part, axis, gains, unit, motor)
        found[identifier(axis.name) if plant.axes else ""] = quantities
    return found


def _gains(control: Json, design: Design, sensors: SensorSettings) -> Gains:
    """Return the PID of an axis; UserError: the control lacks a part of the law."""
    record: Any = design.controller
    had = {"limits.command_rate": design.limits.command_rate or 0.0}
    if record.kind == "pid":
        gains, had["controller.dead_zone"] = Gains(*dict(record.pid).values()), record.dead_zone
    elif record.kind == "pid+ff":
        law = record.law_gains()
        forward = {name: getattr(law, name) for name in FORWARD}
        before = law.kp - law.ki * record.sample_time_s  # without the present error
        gains = Gains(before, law.ki, law.kd, forward, law.width)
        filtered = law.filter_pole > UNFILTERED
        had |= {f"controller.{key}": len(getattr(record, key)) for key in ("signals", "resonators")}
        had["controller.derivative_hz"] = record.derivative_hz if filtered else 0.0
        had["sensors.observer_hz"] = sensors.observer_hz or 0.0
        had["sensors.difference_samples"] = sensors.difference_samples - 1
        for name in FORWARD:
            absent = name not in control["takes"]
            had[f"controller.feed_forward.{name}"] = forward[name] if absent else 0.0
    else:
        raise UserError(f"design {design.name}: controller must be a pid or pid+ff (got {record.kind})")
    for key, value in had.items():
        if value:
            lacking = f"design {design.name}: {key}: {control['called']} has none; search without it"
            raise UserError(f"{lacking}, as with controller.control = {control['form']!r}")
    return gains


def _pid(gains: Gains, unit: float) -> Json:
    """Return the quantities of a PID; ``unit`` is the size of the position's [mm or deg]."""
    forward, load = gains.forward, gains.forward["load"]
    coulomb = forward["coulomb"]
    friction = {"ahead": load + coulomb, "back": load - coulomb, "width": gains.width * unit}
    per = {key: getattr(gains, key) / unit for key in "pid"}
    per |= {key: forward[key] / unit for key in ("velocity", "acceleration")}
    return per | (friction if coulomb else {"load": load})


def _cascade(
    design: Design, axis: Axis, gains: Gains, unit: float, motor: Mapping[str, float]
) -> Json:
    """Return the quantities of a cascade; nan: the motor's data do not suffice.

    Kv and 1/Tn are the roots of ``z^2 - kp/kd z + ki/kd``, Kv is the smaller one. A pulse of the
    commanded speed that begins with twice the Coulomb friction over Kp and decays with Tn steps
    the torque of the PI by twice the friction.
    """
    sum_of, product = (x / gains.d if gains.d > 0 else nan for x in (gains.p, gains.i))
    if not (sum_of > 0 and 0 <= product <= 0.25 * sum_of**2):
        most = f"at most {max(gains.p, 0.0) ** 2 / (4.0 * gains.d):.4g}" if gains.d > 0 else "0"
        ask = "controller.control = 'cascade' keeps a search for a pid+ff there"
        raise UserError(
            f"design {design.name}: ki must be 0 to kp^2/(4 kd), {most}, and kp and kd more than 0, "
            f"as in a cascade (got ki = {gains.i:.4g}); {ask}"
        )
    larger = 0.5 * sum_of + sqrt(0.25 * sum_of**2 - product)
    kv, integral = (product / larger, larger) if product else (larger, 0.0)
    lead, torque, constant = _motor(axis, motor)
    turn = 2.0 * pi * unit / lead  # angle of the motor for a unit of the position [rad]
    radian_p, acceleration = gains.d / turn, gains.forward["acceleration"]
    kp, inertia = radian_p * torque, acceleration * torque / turn
    found = {"kv": kv, "tn": 1.0 / integral if integral else 0.0, "kp": kp}
    found |= {"radian_p": radian_p, "turn_p": 2.0 * pi * kp, "current_p": 2.0 * pi * kp / constant}
    found |= {f"{x}_i": found[f"{x}_p"] * integral for x in ("radian", "turn", "current")}
    found["mode"] = 4.0 if acceleration else 3.0
    if acceleration:
        found |= {"inertia": inertia, "turn_inertia": 2.0 * pi * inertia}
    friction = gains.forward["coulomb"] * torque or _friction(axis, lead)
    if friction and integral:
        found |= {"pulse": 2.0 * friction / kp * lead / (2.0 * pi), "tn_friction": found["tn"]}
    return found


def _motor(axis: Axis, given: Mapping[str, float]) -> list[float]:
    """Return the data of ``MOTOR``; nan: neither given nor known from the plant."""
    plant, units = axis.parameters._asdict(), axis.drive.parameter_units
    known = {"lead": plant.get("lead", plant.get("travel_per_turn", nan))} | dict(given)
    if units.get("amplifier_gain") == "N/V":
        plant.setdefault("torque_gain", plant["amplifier_gain"] * known["lead"] / (2e3 * pi))
    return [known.get(key, plant.get("torque_gain", nan) if key == "torque" else nan) for key in MOTOR]


def _friction(axis: Axis, lead: float) -> float:
    """Return the Coulomb friction of the plant at its motor [N m]; 0 if it has none."""
    turn = {"N": lead / (2e3 * pi), "N m": lead / 360.0}
    load = getattr(axis.parameters, "coulomb_friction", 0.0)
    at_motor = load * turn.get(axis.drive.parameter_units.get("coulomb_friction", ""), 0.0)
    return float(at_motor + getattr(axis.parameters, "motor_friction", 0.0))


def _values(design: Design, axis: str, rows: list[Row], found: Json) -> dict[str, float]:
    """Return the parameters whose quantities are known; UserError: one is out of its range."""
    values, of = {}, f"design {design.name}{f', axis {axis}' if axis else ''}"
    for row in rows:
        if row.of not in found:
            continue
        value = float(f"{found[row.of] * row.factor:.7g}")
        if isnan(value):
            needed = MOTOR[: NEEDED.get(row.of.partition("_")[0], 2)]
            missing = f"{row.name} needs {', '.join(needed)} of the motor"
            raise UserError(f"{of}: {missing}: {option('motor', ...)} {'=...,'.join(needed)}=...")
        if not row.low <= value <= row.high:
            allowed = f"must be {row.low:g} to {row.high:g} ({row.source})"
            raise UserError(f"{of}: {row.name} = {value:g} {row.unit}: {allowed}")
        values[row.name] = value
    return values


def _lines(control: Json, values: Values, axes: list[str]) -> str:
    """Return the lines that enter ``values``; ``axes`` are all axes, by their number."""
    lines = [control["head"]] if "head" in control else []
    for axis, each in values.items():
        place = {"axis": axis or "0", "number": axes.index(axis)}
        lines += [control["section"].format(**place)] if "section" in control else []
        pairs = each.items()
        lines += [control["line"].format(name=key, value=x, **place) for key, x in pairs]
    return "\n".join(lines) + "\n"


def _old(control: Json, path: Path, axes: list[str], rows: list[Row]) -> Values:
    """Return the values in a file of the control, as this module writes it or as INI or HAL."""
    text, known = read_text(path), [row.name for row in rows]
    if path.suffix != ".json":
        return _old_lines(control, path, text, axes, known)
    with as_user_error(path):
        found: Any = json_of(text)
    if not (isinstance(found, dict) and all(isinstance(x, dict) for x in found.values())):
        found = {axes[0]: found}
    for axis, each in found.items():
        if axis not in axes:
            raise UserError(f"{path}: {axis}: unknown axis; {one_of(axis, axes)}")
        for name, x in each.items() if isinstance(each, dict) else [("", each)]:
            if name not in known:
                raise UserError(f"{path}: {name}: unknown parameter; {one_of(name, known)}")
            if isinstance(x, bool) or not isinstance(x, int | float):
                raise UserError(f"{path}: {name}: must be a number (got {x!r})")
    return found  # type: ignore[no-any-return]


def _old_lines(control: Json, path: Path, text: str, axes: list[str], known: list[str]) -> Values:
    """Return the numbers in sections ``[JOINT_0]`` of an INI file, or in ``setp`` of a HAL file."""
    found, place = Values(), set[str]()
    names = {pin: name for name, pin in control.get("pins", {}).items()}
    for line in text.splitlines():
        words = line.partition("#")[0].replace("=", " ").split()
        if len(words) == 3 and words[0] == "setp":
            prefix, _, pin = words[1].rpartition(".")
            place, words = {*re.split(r"[.-]", prefix)}, [names.get(pin, ""), words[2]]
        elif words and words[0].startswith("["):
            place = {words[0].strip("[]").removeprefix("JOINT_")}
        if len(words) > 1 and words[0] in known and number_or_none(words[1]) is not None:
            for k, axis in enumerate(axes):
                if place & {str(k), axis} or (len(axes) == 1 and "pid" in place):
                    found.setdefault(axis, {})[words[0]] = float(words[1])
    if not found:
        raise UserError(f"{path}: has no value of {', '.join(known[:3])} ...; give INI, HAL or JSON")
    return found


FORMATS = tuple(
    Format(name, about["text"], partial(parameters, name), whole=True, parameters=True)
    for name, about in CONTROLS.items()
)
