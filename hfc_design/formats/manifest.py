"""How a design's units are wired, and what surrounds them: the files beside the units' own.

A file of FLL, FCL, FML or FIS holds one unit. ``manifest.csv`` lists the units in evaluation order
with what they read; ``controller.json`` has everything else that the command takes: scales, limits,
gains, and the steps of one sample in words.
"""

import csv
import io
import json
import re
from collections.abc import Collection
from typing import Any

from hfc_design.controllers.flc.record import FlcDesign, FuzzyRecord
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, HierarchicalDesign, InputRecord
from hfc_design.formats.units import RuleUnit, facts, identifier, rule_units
from plants import PLANTS

PREVIOUS = "previous_"


def surroundings(design: Design, suffix: str) -> dict[str, str]:
    """``manifest.csv`` and ``controller.json`` by file name, for units in ``NAME.suffix``.

    Raises:
        UserError: the design is of a kind without rule tables.
    """
    record = json.dumps(_controller(design), indent=1, allow_nan=False)
    return {"manifest.csv": _manifest(rule_units(design), suffix), "controller.json": record + "\n"}


def distinct(design: Design, target: str, reserved: Collection[str]) -> list[RuleUnit]:
    """``rule_units`` whose names and labels are identifiers, each one of its own.

    None is a word of ``reserved`` either. Upper and lower case are alike, as in IEC 61131.

    Raises:
        UserError: they are not.
    """
    units = rule_units(design)
    inputs = ["error", "error_change"]
    if isinstance(design.controller, HierarchicalDesign):
        inputs = [identifier(item.name) for item in design.controller.inputs]
    rows, columns = (
        [t.label for t in terms] for terms in (units[0].row_terms, units[0].column_terms)
    )
    for names in ([*inputs, *(unit.name for unit in units)], rows, columns):
        taken = {word.casefold() for word in reserved}
        for name in names:
            if not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name):
                raise UserError(
                    f"--to {target}: {name} is no identifier there: a letter, then letters, digits "
                    "and single underscores between them; rename it in the design file"
                )
            if name.casefold() in taken:
                raise UserError(
                    f"--to {target}: {name} is a word of that format, or two names are {name} "
                    "there; rename it in the design file"
                )
            taken.add(name.casefold())
    return units


def _manifest(units: list[RuleUnit], suffix: str) -> str:
    rows = [["unit", "column_input", "row_input", "file"]]
    rows += [[unit.name, unit.column, unit.row, f"{unit.name}.{suffix}"] for unit in units]
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(rows)
    return buffer.getvalue()


def _controller(design: Design) -> dict[str, Any]:
    controller = design.controller
    signal_units = PLANTS[design.plant.name].units if design.plant.name in PLANTS else {}
    head = {
        "facts": facts(design),
        "sample_time_s": controller.sample_time_s,
        "command_unit": signal_units.get("command", ""),
    }
    if isinstance(controller, HierarchicalDesign):
        return head | _hierarchy(controller, signal_units)
    assert isinstance(controller, FuzzyRecord)  # rule_units refuses all others
    return head | _feed_drive(controller)


def _hierarchy(controller: HierarchicalDesign, signal_units: dict[str, str]) -> dict[str, Any]:
    root = f"unit_{controller.units[-1].id}"
    steps = [
        "input = min(max(scale * signal, lowest), highest); with samples_ago 1 the signal is that "
        "of the previous sample, before the first one 0",
        "the units of manifest.csv in its order; each reads inputs or earlier units",
        f"command = kp * error + kd * error_rate + output_scale * {root}",
    ]
    if controller.adaptation is not None:
        steps.append(f"the adaptation of {root} is not here: its table is the one to start from")
    return {
        "steps": steps,
        "inputs": [_input(item, signal_units) for item in controller.inputs],
        "output": root,
        "output_scale": controller.output_scale,
        "kp": controller.pd.kp,
        "kd": controller.pd.kd,
    }


def _input(item: InputRecord, signal_units: dict[str, str]) -> dict[str, Any]:
    signal = item.name.removeprefix(PREVIOUS)
    return {
        "name": identifier(item.name),
        "signal": signal,
        "signal_unit": signal_units.get(signal, ""),
        "samples_ago": int(item.name.startswith(PREVIOUS)),
        "scale": item.scale,
        "lowest": -1.0,
        "highest": 1.0,
    }


def _feed_drive(controller: FuzzyRecord) -> dict[str, Any]:
    form = controller.form if isinstance(controller, FlcDesign) else "PD"
    low = controller.low_velocity
    change = "0" if form == "P" else "error - error of the previous sample, before the first one 0"
    action = "rules" if form != "PI" else "sum of the outputs of rules up to this sample"
    steps = [
        f"error_change = {change}",
        "the unit rules reads both in BLU; they are neither scaled nor limited",
        "integral = sum of integral_gain * sample_time_s * error up to this sample",
        f"command = {action} + integral" + (" + compensation" if low else ""),
    ]
    if low:
        steps += [
            "v = 0.01 * velocity [BLU/s] in mm/s; at |v| < 0.5 compensation = breakaway[0] where "
            "error >= smallest_error, breakaway[1] where error <= -smallest_error, else 0",
            "at 0.5 <= |v| < highest_velocity_mm_s compensation = a v^2 + b v + c with forward for "
            "v >= 0 and backward for v < 0; beyond it 0",
        ]
    if not isinstance(controller, FlcDesign):
        steps.append("the adaptation is not here: the rules and terms are those to start from")
    return {
        "steps": steps,
        "form": form,
        "output": "rules",
        "integral_gain": controller.integral_gain,
        "low_velocity": low.model_dump(mode="json") if low else None,
    }
