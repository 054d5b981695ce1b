"""Export of the rule tables of a hierarchy to other programs, and explanation of its command."""

import math

from hfc_design.controllers import rules
from hfc_design.controllers.hierarchical.law import PREVIOUS, HierarchicalMemory, HierarchyParts
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, InputRecord, TermRecord
from hfc_design.controllers.kind import Explain
from hfc_design.controllers.linear.code import about as linear_about
from hfc_design.controllers.linear.code import shares as linear_shares
from hfc_design.controllers.linear.law import AHEAD, ERRORS
from hfc_design.core.numbers import Json


def units(record: HierarchicalDesign) -> list[rules.RuleUnit]:
    """Return the units, which read inputs clamped to [-1, 1]; the root is as adapted so far."""
    terms = tuple(map(_flat, record.terms))
    rule_units = []
    for unit, table in zip(record.units, record.tables(), strict=True):
        column, row = rules.identifier(unit.column_input), rules.identifier(unit.row_input)
        rule_units.append(rules.RuleUnit(f"unit_{unit.id}", column, row, terms, terms, table))
    return rule_units


def _flat(term: TermRecord) -> rules.FlatGaussian:
    low, high = term.centre - term.half_width, term.centre + term.half_width
    return rules.FlatGaussian(term.label, low, high, 1.0 / math.sqrt(2.0 * term.rate))


def inputs(record: HierarchicalDesign) -> list[str]:
    """Return the names of the inputs as in the design file."""
    return [item.name for item in record.inputs]


def about(record: HierarchicalDesign, signal_units: dict[str, str]) -> Json:
    """Return by key the inputs with scales and limits, the output's scale and the linear gains."""
    root = f"unit_{record.units[-1].id}"
    part, scheduled = record.linear_part, record.scheduled_part
    whole: Json = {
        "inputs": [_input(item, signal_units) for item in record.inputs],
        "output": root,
        "output_scale": record.output_scale,
        "kp": record.pd.kp,
        "kd": record.pd.kd,
    }
    if part:
        whole["linear"] = linear_about(part, signal_units)
    if scheduled:
        gains = {"kp": scheduled.kp, "kd": scheduled.kd}
        whole["scheduled"] = gains | linear_about(scheduled, signal_units)
    return whole


def _input(item: InputRecord, signal_units: dict[str, str]) -> Json:
    signal = item.name.removeprefix(PREVIOUS)
    return {
        "name": rules.identifier(item.name),
        "signal": signal,
        "signal_unit": signal_units.get(signal, ""),
        "samples_ago": int(item.name.startswith(PREVIOUS)),
        "scale": item.scale,
        "lowest": -1.0,
        "highest": 1.0,
    }


def notes(record: HierarchicalDesign) -> list[str]:
    """Return notes on the units of the signals and on what the rule tables do not contain."""
    lines = ["inputs are scaled and clamped to -1 .. 1; inputs and output have no unit"]
    if record.linear is not None:
        added = "integral, resonators" if record.linear.resonators else "integral"
        lines.append(f"{added}, gains on signals and feed-forward are not included: they are added")
    if record.scheduled is not None:
        lines.append("the output multiplies a linear law, which is not included either")
    if record.adaptation is not None:
        lines.append("the root's table is the one from which its adaptation starts")
    return lines


def tables(record: HierarchicalDesign) -> dict[str, rules.Rows]:
    """Return the rows of ``unit-N.csv``, one file for each unit N, and of ``manifest.csv``."""
    labels = [term.label for term in record.terms]
    manifest = [["unit", "column_input", "row_input", "file"]]
    files = {}
    for unit, table in zip(record.units, record.tables(), strict=True):
        name = f"unit-{unit.id}.csv"
        corner = f"row {unit.row_input} \\ column {unit.column_input}"
        files[name] = rules.rows_of(corner, labels, labels, table)
        manifest.append([f"unit-{unit.id}", unit.column_input, unit.row_input, name])
    return files | {"manifest.csv": manifest}


def signals(record: HierarchicalDesign) -> tuple[list[str], list[str]]:
    """Return the signals read in a sample, and the inputs that are readings of the previous one."""
    return reads(record), [name for name in inputs(record) if name.startswith(PREVIOUS)]


def reads(record: HierarchicalDesign) -> list[str]:
    """Return the signals read in a sample; those that are only needed a sample later come last."""
    names = sorted(inputs(record), key=lambda name: name.startswith(PREVIOUS))
    input_signals = (name.removeprefix(PREVIOUS) for name in names)
    scheduled_signals = record.scheduled.signals if record.scheduled else ()
    further = (*record.linear.signals, *scheduled_signals, *AHEAD) if record.linear else ()
    return list(dict.fromkeys([*ERRORS, *further, *input_signals]))


def remember(memory: HierarchicalMemory, readings: dict[str, float]) -> HierarchicalMemory:
    """Return the memory with these ``readings`` as those of the previous sample."""
    return memory._replace(readings={**memory.readings, **readings})


def shown(record: HierarchicalDesign, parts: HierarchyParts) -> Json:
    """Return by key the inputs, the units with fired rules, and the parts of a sample's command."""
    labels = [term.label for term in record.terms]
    each = zip(record.inputs, parts.readings, parts.scaled, strict=True)
    scaled = [{"name": x.name, "reading": y, "scale": x.scale, "scaled": u} for x, y, u in each]
    units = []
    for unit, firing in zip(record.units, parts.units, strict=True):
        column = rules.side(unit.column_input, firing.column, labels, firing.in_column)
        row = rules.side(unit.row_input, firing.row, labels, firing.in_row)
        units.append(rules.fired(f"unit-{unit.id}", column, row, firing.table, firing.output))
    shares = {key: float(getattr(parts, key)) for key in ("proportional", "derivative")}
    if (part := record.linear_part) and parts.linear:
        shares = linear_shares(part, parts.linear)
    shares["fuzzy"] = float(parts.fuzzy)
    whole: Json = {"inputs": scaled, "units": units, "output_scale": record.output_scale}
    whole["parts"] = shares
    if (scheduled := record.scheduled_part) and parts.scheduled:
        whole["scheduled"] = linear_shares(scheduled, parts.scheduled)
        del whole["scheduled"]["integral"]
    return whole


RULES = rules.RuleBase(units, inputs, about, notes, tables)
EXPLAIN = Explain(signals, remember, shown)
