"""Which rules of a design fire at a sample, and what the command is made of, as numbers.

All of them come from the runtime's own step: nothing is computed here but shares of the firing.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from hfc_design.controllers.flc.law import Parts
from hfc_design.controllers.flc.record import AflcDesign, FlcDesign, FuzzyRecord, SoflcDesign
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, HierarchicalDesign
from hfc_design.runtime import PREVIOUS, Controller, HierarchyParts
from plants import PLANTS

Sample = dict[str, float]


def explanation(design: Design, texts: Sequence[str]) -> dict[str, Any]:
    """The last of the samples ``texts`` as in ``error=1e-4,deflection=2e-4``, explained.

    Those before it are stepped through first, from rest, as the runtime does. With one sample
    only, what the controller reads of the sample before it has to be given too
    (``previous_velocity=...``; of a feed drive ``previous_error=...`` or ``error_change=...``).
    Then everything else is as before the first sample: the integral starts at 0, and terms and
    rules that adapt are not judged, because which rules fired before is not known.

    Raises:
        UserError: the design has no rules, or signals are missing, unknown or no numbers.
    """
    record = design.controller
    if not isinstance(record, HierarchicalDesign | FuzzyRecord):
        raise UserError(f"design {design.name} is of kind {record.kind}: it has no rules")
    samples = [_sample(text) for text in texts]
    alone = len(samples) == 1
    for sample in samples:
        _check(design, sample, alone)
    controller = Controller(_held(design) if alone else design)
    controller.remember(_memory(samples[0]))
    for sample in samples[:-1]:
        controller.step(sample)
    parts = controller.parts(samples[-1])
    if isinstance(parts, HierarchyParts):
        assert isinstance(record, HierarchicalDesign)
        found = _hierarchy(record, parts)
    else:
        assert isinstance(record, FuzzyRecord)
        found = _fuzzy(record, parts)
    plant = PLANTS[design.plant.name]
    command = float(parts.command())
    machine = plant.coefficients(plant.parameters(**design.plant.parameters))
    return {
        "design": design.name,
        "kind": record.kind,
        "signals": samples[-1],
        "units_of_signals": {name: _unit(design, name) for name in samples[-1]},
        **found,
        "command": command,
        "accepted": float(plant.accepted(machine, command)),  # by the drive's converter
        "command_unit": plant.units["command"],
        "adaptation_held": alone and getattr(record, "adaptation", None) is not None,
    }


def _sample(text: str) -> Sample:
    found: Sample = {}
    for item in text.split(","):
        name, _, value = (part.strip() for part in item.partition("="))
        try:
            reading = float(value)
        except ValueError:
            reading = math.nan
        if not name or not math.isfinite(reading):
            raise UserError(f"--at {item[:60]!r}: has to be SIGNAL=NUMBER, as in error=1e-4")
        if name in found:
            raise UserError(f"--at {text[:60]}: {name} stands there twice")
        found[name] = reading
    return found


def _check(design: Design, sample: Sample, alone: bool) -> None:
    """Whether a sample holds what the controller reads and nothing else."""
    now, before = read_signals(design)
    names = [*now, *before] if alone else now
    if isinstance(design.controller, FuzzyRecord) and before and alone:
        names.append("error_change")
    listed = ", ".join(names)
    for name in sample:
        if name not in names:
            why = f"{design.name} reads {listed}"
            if not alone and (name in before or name == "error_change"):
                why = "several --at start from rest, and each is the one before the next"
            raise UserError(f"--at {name}={sample[name]:g}: no such signal; {why}")
    if "error_change" in sample and f"{PREVIOUS}error" in sample:
        raise UserError("--at: of error_change and previous_error only one can be given")
    if "error_change" in sample:
        before = []
    for name in [*now, *(before if alone else [])]:
        if name not in sample:
            other = " (or error_change)" if name in before and "error_change" in names else ""
            raise UserError(f"--at: {name}{other} is missing; {design.name} reads {listed}")


def read_signals(design: Design) -> tuple[list[str], list[str]]:
    """Signals that the controller reads at a sample, and those it remembers of the one before."""
    record = design.controller
    if isinstance(record, HierarchicalDesign):
        before = [item.name for item in record.inputs if item.name.startswith(PREVIOUS)]
        now = [item.name for item in record.inputs if item.name not in before]
        now = ["error", "error_rate", *now, *(name.removeprefix(PREVIOUS) for name in before)]
        return list(dict.fromkeys(now)), before
    assert isinstance(record, FuzzyRecord)
    now = ["error", "velocity"] if record.low_velocity else ["error"]
    no_change = isinstance(record, FlcDesign) and record.form == "P"
    return now, [] if no_change else [f"{PREVIOUS}error"]


def _memory(sample: Sample) -> Sample:
    """Readings of the sample before, as far as ``sample`` tells them."""
    found = {
        name.removeprefix(PREVIOUS): value
        for name, value in sample.items()
        if name.startswith(PREVIOUS)
    }
    if "error_change" in sample:
        found["error"] = sample["error"] - sample["error_change"]
    return found


def _held(design: Design) -> Design:
    """The same without adaptation."""
    record = design.controller
    if not isinstance(record, AflcDesign | SoflcDesign):
        return design
    steps = record.adaptation.model_copy(update={"k_a": 0.0, "k_b": 0.0, "k_c": 0.0})
    held = record.model_copy(update={"adaptation": steps})
    return design.model_copy(update={"controller": held})


def _hierarchy(record: HierarchicalDesign, parts: HierarchyParts) -> dict[str, Any]:
    labels = [term.label for term in record.terms]
    inputs = [
        {"name": item.name, "reading": reading, "scale": item.scale, "scaled": u}
        for item, reading, u in zip(record.inputs, parts.readings, parts.scaled, strict=True)
    ]
    units = []
    for unit, firing in zip(record.units, parts.units, strict=True):
        column = _side(unit.column_input, firing.column, labels, firing.in_column)
        row = _side(unit.row_input, firing.row, labels, firing.in_row)
        units.append(_unit_of(f"unit-{unit.id}", column, row, firing.table, firing.output))
    shares = {
        "proportional": float(parts.proportional),
        "derivative": float(parts.derivative),
        "fuzzy": float(parts.fuzzy),
    }
    return {"inputs": inputs, "units": units, "output_scale": record.output_scale, "parts": shares}


def _fuzzy(record: FuzzyRecord, parts: Parts) -> dict[str, Any]:
    labels = [term.label for term in record.error_terms]
    column = _side("error_change", parts.change, labels, parts.in_change)
    row = _side("error", parts.error, labels, parts.in_error)
    unit = _unit_of("rules", column, row, parts.singletons, parts.inferred)
    shares = {"fuzzy": float(parts.fuzzy), "integral": float(parts.integral)}
    if parts.compensation is not None:
        shares["compensation"] = float(parts.compensation)
    return {"units": [unit], "parts": shares}


def _side(
    name: str, value: float, labels: Sequence[str], degrees: Iterable[float]
) -> dict[str, Any]:
    pairs = zip(labels, map(float, degrees), strict=True)
    return {"input": name, "value": float(value), "degrees": dict(pairs)}


def _unit_of(
    name: str, column: dict[str, Any], row: dict[str, Any], table: Any, output: float
) -> dict[str, Any]:
    """One unit with the rules that fire, the strongest first."""
    in_column, in_row = (np.array(list(side["degrees"].values())) for side in (column, row))
    strength = np.outer(in_row, in_column)
    total = float(strength.sum())
    rules = [
        {
            "row": list(row["degrees"])[i],
            "column": list(column["degrees"])[j],
            "strength": float(strength[i, j]),
            "share": float(strength[i, j] / total),
            "consequent": float(table[i][j]),
        }
        for i, j in zip(*np.nonzero(strength), strict=True)
    ]
    rules.sort(key=lambda rule: -rule["strength"])
    return {"unit": name, "column": column, "row": row, "rules": rules, "output": float(output)}


def _unit(design: Design, name: str) -> str:
    units = PLANTS[design.plant.name].units
    return units["error" if name == "error_change" else name.removeprefix(PREVIOUS)]
