"""Designs of kinds ``pid`` and ``pid+ff`` as parameters of controls that take no foreign law.

``controls.toml`` lists the controls. Their integrals contain the error of the present sample. A
cascade of P and PI with full feed-forward of the velocity is a PID with ``kd = Kp``,
``kp = Kp (Kv + 1/Tn)`` and ``ki = Kp Kv / Tn``.
"""

import json
import re
import tomllib
from collections import namedtuple
from functools import partial
from math import isnan, nan, pi, sqrt
from pathlib import Path
from typing import Any

from hfc_design.controllers.linear.law import LinearGains
from hfc_design.controllers.linear.record import MULTIPLES
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError, option
from hfc_design.core.texts import as_user_error, json_of, read_text
from hfc_design.core.wording import one_of
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import machine, own_scenario
from hfc_design.files.machine import Axis, SensorSettings
from hfc_design.formats.deployment import readme
from hfc_design.formats.writing import NUMBER, Content, Format, rendered

CONTROLS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
#: Data of the motor: travel of the axis in a turn [mm or deg], torque for a command [N m] and for a
#: current [N m/A]; how many of them a quantity needs, by the first part of its name; others: two.
MOTOR, NEEDED = ("lead", "torque", "torque_constant"), {"radian": 1, "current": 3}
#: Row of ``controls.toml``, which explains the fields.
Row = namedtuple("Row", "name of factor unit low high meaning source")


def parameters(
    name: str, design: Design, motor: Json | None = None, old: str | Path = ""
) -> dict[str, Content]:
    """Return the files of a design for the control ``name``: values, lines to enter, README.

    ``motor`` has data of ``MOTOR`` that the plant lacks; ``old`` is a file of the present values.

    Raises:
        UserError: the control lacks a part of the law, a datum is missing, a value is outside its
            range, or ``old`` is not valid.
    """
    control: Json = CONTROLS[name]
    rows = [Row(*row) for row in control["parameters"]]
    axes = _modes(design) if control["form"] == "modes" else _axes(control, design, motor or {})
    new = {axis: _values(f"design {design.name}", rows, found) for axis, found in axes.items()}
    before = _old(control, Path(old), new) if old else {}
    about: Json = {"control": control, "rows": rows, "new": new, "old": before, "axes": axes}
    files: dict[str, Content] = {}
    for k, (stem, values) in enumerate({"parameters": new, "restore": before}.items()):
        if values:
            files[f"{stem}.json"] = json.dumps(values.get("", values), indent=1) + "\n"
            if "line" in control:
                lines = rendered("controls/lines.j2", design, values=values, **about)
                files[control["files"][k]] = lines
    if control["form"] == "pid":
        files["pid.hal"] = rendered("controls/pid.hal.j2", design, **about)
    about |= {"about": readme.origin(design), "kind": design.kind.name}
    return files | {"README.md": rendered("controls/README.md.j2", design, **about)}


def _modes(design: Design) -> dict[str, Json]:
    """Return frequency and damping of the modes in the design's scenario, for two axes."""
    modes = own_scenario(design, design.name).stress.modes
    if not 0 < (count := len(modes)) < 3:
        raise UserError(f"design {design.name}: stress.modes must be 1 or 2, X and Y (got {count})")
    each = ({"mode_hz": one.hz, "mode_damping": one.damping} for one in (modes[0], modes[-1]))
    return dict(zip("xy", each, strict=True))


def _axes(control: Json, design: Design, motor: Json) -> dict[str, Json]:
    """Return the quantities of each axis by name, in mm or deg, s, N m; "" is an only axis."""
    for key, x in motor.items():
        if key not in MOTOR or isinstance(x, str) or not x > 0:
            wrong = "must be a number above 0" if key in MOTOR else f"unknown; {one_of(key, MOTOR)}"
            raise UserError(f"{option('motor', x, key=key)}: {wrong}")
    scenario = own_scenario(design, design.name)
    plant, parts, quantities = machine(design, scenario), design.by_axis(), {}
    for axis in plant.each():
        part, sensors = parts.get(axis.name, design), scenario.sensors.of(axis.name)
        kind, drive = part.controller.kind, axis.drive
        gains = _gains(control, part, sensors)
        # The integral of pid+ff lacks the present error, which the controls' integrals contain.
        late = part.controller.sample_time_s if kind == "pid+ff" else 0.0
        unit = axis.length or (180.0 / pi if drive.units["error"] == "rad" else 1.0)
        position = sensors.feedback or drive.seen[0]
        reads = sensors.velocity == "tachometer" and kind == "pid+ff"
        rate = drive.encoders.get(position, drive.velocity) if reads else ""
        of: Json = {"kind": kind, "fed_position": position, "fed_velocity": rate}
        of |= {"zero": 0.0, "one": 1.0, "limit": part.limits.of(axis.name).command or 0.0}
        if hasattr(axis.parameters, "backlash"):  # behind it an encoder measures the error itself
            of["backlash"] = axis.parameters.backlash * unit * (position != drive.position)
        if control["form"] == "cascade":
            of |= _cascade(part.name, axis, gains, late, unit, motor)
        else:
            gains = gains._replace(kp=gains.kp - gains.ki * late)
            of |= {key: getattr(gains, f"k{key}") / unit for key in "pid"}
            of |= {key: getattr(gains, key) / unit for key in ("velocity", "acceleration")}
            friction = {"coulomb": gains.coulomb, "width": gains.width * unit}
            of |= {"load": gains.load} | (friction if gains.coulomb else {})
        quantities[identifier(axis.name) if plant.axes else ""] = of
    return quantities


def _gains(control: Json, design: Design, sensors: SensorSettings) -> LinearGains:
    """Return the PID of an axis; UserError: the control lacks a part of the law."""
    record: Any = design.controller
    had = {"limits.command_rate": design.limits.command_rate or 0.0}
    if record.kind == "pid":
        gains = LinearGains(*dict(record.pid).values())
        had["controller.dead_zone"] = record.dead_zone
    elif record.kind == "pid+ff":
        gains = record.law_gains()
        had |= {f"controller.{key}": len(getattr(record, key)) for key in ("signals", "resonators")}
        had["controller.derivative_hz"] = gains.filter_pole > 1e-6
        if control["form"] == "pid":
            had["sensors.observer"] = sensors.observer_hz or 0.0
            had["sensors.difference_samples"] = sensors.difference_samples - 1
        lacking = (name for name in MULTIPLES if name not in control["takes"])
        had |= {f"controller.feed_forward.{name}": getattr(gains, name) for name in lacking}
    else:
        raise UserError(f"design {design.name} is of kind {record.kind}: must be pid or pid+ff")
    if keys := [key for key, value in had.items() if value]:
        form = f"controller.control = {control['form']!r}"
        forward = [key.rpartition(".")[2] for key in keys if "forward" in key]
        ranges = [f"controller.ranges.{name}_multiple = [0, 0]" for name in forward]
        how = ", ".join([*ranges, *(form for key in keys if "hz" in key)])
        inner = " (of the speed it has all, in kd)" * ("velocity" in forward)
        it = "them" if keys[1:] else "it"
        raise UserError(
            f"design {design.name}: {control['called']} lacks {', '.join(keys)}{inner}; "
            f"search without {it}{how and ', as with '}{how}"
        )
    return gains


def _cascade(
    name: str, axis: Axis, gains: LinearGains, late: float, unit: float, motor: Json
) -> Json:
    """Return the quantities of a cascade; nan: the motor's data do not suffice.

    Kv and 1/Tn are the roots of ``z^2 - kp/kd z + ki/kd`` with kp less ``ki late``, Kv is the
    smaller one; both are real for ki up to ``most``. A pulse of the
    commanded speed that begins with twice the Coulomb friction over Kp and decays with Tn steps
    the torque of the PI by twice the friction.
    """
    kp, ki, kd = gains.kp, gains.ki, gains.kd
    most = (kp / (sqrt(kd) + sqrt(kd + kp * late))) ** 2 if kp > 0 and kd > 0 else nan
    if not 0 <= ki <= most:
        limit = "" if isnan(most) else f" and ki 0 to {most:.4g}"
        wanted = f"kp and kd must be more than 0{limit} for a cascade"
        keeps = "a search for a pid+ff with controller.control = 'cascade' keeps to that"
        raise UserError(f"design {name}: {wanted} (got {kp:.4g}, {kd:.4g}, {ki:.4g}); {keeps}")
    kp -= ki * late
    larger = 0.5 * kp / kd + sqrt(max(0.25 * (kp / kd) ** 2 - ki / kd, 0.0))
    kv, integral = (ki / kd / larger, larger) if ki else (larger, 0.0)
    lead, torque, constant, friction = _motor(axis, motor)
    turn = 2.0 * pi * unit / lead  # angle of the motor for a unit of the position [rad]
    per_radian, inertia = kd / turn, gains.acceleration * torque / turn
    values = {"kv": kv, "tn": 1.0 / integral if integral else 0.0, "kp": per_radian * torque}
    per_turn = 2.0 * pi * values["kp"]
    values |= {"radian_p": per_radian, "turn_p": per_turn, "current_p": per_turn / constant}
    values |= {f"{x}_i": values[f"{x}_p"] * integral for x in ("radian", "turn", "current")}
    values["mode"] = 4.0 if gains.acceleration else 3.0  # with or without feed-forward of torque
    if gains.acceleration:
        values |= {"inertia": inertia, "turn_inertia": 2.0 * pi * inertia}
    friction = gains.coulomb * torque or friction
    if friction and integral and axis.length:
        values |= {"pulse": friction / values["kp"] * lead / pi, "tn_friction": values["tn"]}
    return values


def _motor(axis: Axis, given: Json) -> tuple[float, float, float, float]:
    """Return the data of ``MOTOR`` (nan: not known), and the plant's Coulomb friction [N m]."""
    plant, units = axis.parameters._asdict(), axis.drive.parameter_units
    lead = given.get("lead", plant.get("lead", plant.get("travel_per_turn", nan)))
    torque, turn = plant.get("torque_gain", nan), lead / (2e3 * pi)  # [m/rad]
    if units.get("amplifier_gain") == "N/V":
        torque = plant["amplifier_gain"] * turn
    friction = plant.get("coulomb_friction", 0.0) * turn + plant.get("motor_friction", 0.0)
    return lead, given.get("torque", torque), given.get("torque_constant", nan), friction


def _values(of: str, rows: list[Row], quantities: Json) -> dict[str, float]:
    """Return the parameters whose quantities are known; UserError: one is out of its range."""
    values, known = {}, [row for row in rows if row.of in quantities]
    if without := [row for row in known if isnan(quantities[row.of])]:
        needed = MOTOR[: max(NEEDED.get(row.of.partition("_")[0], 2) for row in without)]
        names = ", ".join(row.name for row in without)
        raise UserError(f"{of}: {option('motor')} must have {', '.join(needed)}, for {names}")
    for row in known:
        value = float(f"{quantities[row.of] * row.factor:.7g}")
        if not row.low <= value <= row.high:
            allowed = f"must be {row.low:g} to {row.high:g} ({row.source})"
            raise UserError(f"{of}: {row.name} = {value:g} [{row.unit}]: {allowed}")
        values[row.name] = value
    return values


def _old(control: Json, path: Path, new: Json) -> Json:
    """Return the values of a file like ``parameters.json``, or for LinuxCNC of an INI or HAL file.

    Those are ``NAME = number`` in ``[JOINT_0]`` and ``setp pid.0.PIN number``.
    """
    text, by_axis = read_text(path), {}
    as_json = "pins" not in control or path.suffix == ".json"
    with as_user_error(path):
        whole: Any = json_of(text) if as_json else {}
    for k, (axis, names) in enumerate(new.items()):
        part = whole.get(axis, whole) if isinstance(whole, dict) else None
        each = {**part} if isinstance(part, dict) else {}
        for name in () if as_json else names:
            place = rf"\[JOINT_{k}\](?:\n(?!\[).*)*?\n[ \t]*{name}[ \t]*="
            pid = rf"(?:\S{{0,47}}[.-])?(?:{k}|{axis or 'pid'})(?:[.-]\S{{0,47}})?"
            pin = rf"[ \t]*setp[ \t]+{pid}\.{control['pins'].get(name)}[ \t]"
            if match := re.search(
                rf"(?m)^(?:{place}|{pin})[ \t]*({NUMBER.pattern})[ \t]*(?:#|$)", text
            ):
                each[name] = float(match[1])
        by_axis[axis] = {key: x for key in names if type(x := each.get(key)) in (int, float)}
        for key, value in each.items():
            if type(value) in (int, float) and key not in names:
                raise UserError(f"{path}: {key}: unknown name; {one_of(key, names)}")
    if not any(by_axis.values()):
        raise UserError(f"{path}: has no number of {', '.join(names)}")
    return by_axis


FORMATS = tuple(
    Format(name, about["text"], partial(parameters, name), whole=True, parameters=True)
    for name, about in CONTROLS.items()
)
