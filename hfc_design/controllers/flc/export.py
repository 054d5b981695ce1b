"""Export of a fuzzy controller's rule table to other programs, and explanation of its command.

The exported rules and terms of an adaptive kind are those before it adapts.
"""

import numpy as np

from hfc_design.controllers.flc.law import Parts
from hfc_design.controllers.flc.record import USUAL, FuzzyRecord, signals_of
from hfc_design.controllers.kind import Explain
from hfc_design.controllers.neighbours import spread
from hfc_design.controllers.rules import Rows, RuleBase, RuleUnit, Triangle, fired, rows_of, side
from hfc_design.core.numbers import Json, Memory


def units(record: FuzzyRecord) -> list[RuleUnit]:
    """Return the only rule table, with variables named as in ``record.names``."""
    unit, names, rules = plain_unit(record), record.names, record.rules
    called = unit._replace(
        name=names.output,
        column=names.error_change,
        row=names.error,
        labels=None if rules.output_terms is None else rules.labels,
        engine=names.engine or "",
        ranges={getattr(names, key): ends for key, ends in record.ranges.items()},
    )
    return [called]


def plain_unit(record: FuzzyRecord) -> RuleUnit:
    """Return the rule table, with variables named as everywhere in this package."""
    sides = record.sides.values()
    error, change = (tuple(Triangle(x.label, *x.edges()) for x in terms) for terms in sides)
    return RuleUnit("rules", "error_change", "error", change, error, record.rules.centroids)


def inputs(record: FuzzyRecord) -> list[str]:
    """Return the names of the column input and of the row input."""
    return [record.names.error_change, record.names.error]


def about(record: FuzzyRecord, signal_units: dict[str, str]) -> Json:
    """Return by key form, output, integral gain, compensation, unusual names and dead zone."""
    low, form, names = record.low_velocity, record.control_form(), record.names
    return {
        "form": form,
        "output": names.output,
        "integral_gain": record.integral_gain,
        "low_velocity": low.model_dump(mode="json") if low else None,
        **({"names": names.model_dump()} if names != USUAL else {}),
        **({"dead_zone": record.dead_zone} if record.dead_zone else {}),
    }


def notes(record: FuzzyRecord) -> list[str]:
    """Return notes on the units of the signals and on what the rule table does not contain."""
    lines = ["error and error_change in BLU, output in units of the command"]
    if record.adapts:
        starts = f"those from which the adaptation of an {record.kind} starts"
        lines.append(f"terms and rules are {starts}; the adaptation itself is not included")
    elif record.control_form() == "PI":
        lines.append("form PI: the output is the change of the command in a sample")
    return lines


def tables(record: FuzzyRecord) -> dict[str, Rows]:
    """Return the rows of ``rules.csv``, ``manifest.csv`` and the files of terms and labels."""
    names, rules = record.names, record.rules
    error, change = labels_of(record)
    corner = f"row {names.error} [BLU] \\ column {names.error_change} [BLU]"
    files = {"rules.csv": rows_of(corner, error, change, rules.centroids)}
    manifest = [["unit", "column_input", "row_input", "file"]]
    unit = record.kind if names.output == USUAL.output else names.output
    manifest.append([unit, names.error_change, names.error, "rules.csv"])
    if rules.output_terms is not None:
        files["labels.csv"] = rows_of(corner, error, change, rules.labels, str)
    for key, terms in record.sides.items():
        rows = [["label", "left_BLU", "centre_BLU", "right_BLU"]]
        for term in terms:
            edges = (term.left, term.centre, term.right)
            rows.append([term.label, *("" if edge is None else repr(edge) for edge in edges)])
        files[f"{key}.csv"] = rows
    return files | {"manifest.csv": manifest}


def labels_of(record: FuzzyRecord) -> tuple[list[str], list[str]]:
    """Return the labels of the error's terms, and those of the terms of the change of error."""
    error, change = ([term.label for term in terms] for terms in record.sides.values())
    return error, change


def signals(record: FuzzyRecord) -> tuple[list[str], list[str]]:
    """Return the signals read in a sample, and the readings kept from the previous sample."""
    return record.reads(), [] if record.control_form() == "P" else ["previous_error"]


def remember(memory: Memory, readings: dict[str, float]) -> Memory:
    """Return the memory with these ``readings`` as those of the previous sample."""
    return memory._replace(**readings)


def shown(record: FuzzyRecord, parts: Parts) -> Json:
    """Return by key the unit with the rules that fire, and the parts of a sample's command."""
    names, (error, change) = record.names, labels_of(record)
    labels = None if record.rules.output_terms is None else record.rules.labels
    column = side(names.error_change, parts.change, change, spread(parts.in_change, len(change)))
    row = side(names.error, parts.error, error, spread(parts.in_error, len(error)))
    unit = fired(names.output, column, row, parts.singletons, parts.inferred, labels)
    shares = {"fuzzy": float(parts.fuzzy), "integral": float(parts.integral)}
    if parts.compensation is not None:
        shares["compensation"] = float(parts.compensation)
    return {"units": [unit], "parts": shares}


def apart(one: float, other: float) -> float:
    """Return the distance of two numbers that are rounded to single precision."""
    with np.errstate(over="ignore", invalid="ignore"):
        return abs(float(np.float32(one) - np.float32(other)))


def widths(record: FuzzyRecord) -> list[float]:
    """Return the distance of every edge of a term from the term's centre, in single precision."""
    table = record.table()
    terms = (*table.error_terms, *table.change_terms)
    return [apart(edge, term[1]) for term in terms for edge in term[::2]]


RULES = RuleBase(units, inputs, about, notes, tables)
EXPLAIN = Explain(
    signals,
    remember,
    shown,
    changes={"error_change": "previous_error"},
    names=lambda record: signals_of(record.names),
)
