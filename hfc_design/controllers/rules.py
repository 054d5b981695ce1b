"""Rule tables in the form that every format and every explanation uses, for all kinds.

Names and labels are identifiers (``records.Label``, ``records.Name``), everything else is a
number, so that no free text of a user gets into a generated file. Never imports JAX.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Json, Own, RuleTable

Rows = list[list[str]]


class FlatGaussian(NamedTuple):
    """Term with degree 1 from ``low`` to ``high`` and Gaussian tails of ``sigma`` (LL eq. 3)."""

    label: str
    low: float
    high: float
    sigma: float


class Triangle(NamedTuple):
    """Triangular term (JK04 eq. 1); an outermost one is 1 beyond its centre, its edge infinite."""

    label: str
    left: float
    centre: float
    right: float


Term = FlatGaussian | Triangle


class RuleUnit(NamedTuple):
    """Fuzzy unit of two inputs; its output is a weighted average of numbers (singletons)."""

    name: str  # identifier of the unit and of its output
    column: str  # identifier of the input of the columns: a signal or an earlier unit
    row: str  # identifier of the input of the rows
    column_terms: tuple[Term, ...]
    row_terms: tuple[Term, ...]
    table: RuleTable  # singletons [row term][column term]
    #: Name of each singleton [row term][column term], if rules share singletons; else None.
    labels: Sequence[Sequence[str]] | None = None
    engine: str = ""  # identifier of the fuzzy system in a file; "": the name of the unit
    #: Name of an input or output -> its range in the file that the unit was imported from.
    ranges: Mapping[str, tuple[float, float]] = {}


class RuleBase(NamedTuple):
    """Functions that give the rule tables of a kind's records to the formats."""

    #: Units in the order of their evaluation; the last one gives the output.
    units: Callable[[Own], list[RuleUnit]]
    #: Names of the inputs, in the order in which a MATLAB file numbers them.
    inputs: Callable[[Own], list[str]]
    #: (record, units of the signals) -> everything besides the units that a command depends on.
    about: Callable[[Own, dict[str, str]], Json]
    #: Lines that a reader of a unit's file has to know.
    notes: Callable[[Own], list[str]]
    #: Rule tables as CSV files: name of a file -> its rows.
    tables: Callable[[Own], dict[str, Rows]]


def range_of(triangles: Sequence[tuple[float, float, float]]) -> tuple[float, float]:
    """Return an input's range: the outermost centres, moved out as far as to their inner edges."""
    (_, lowest, right), (left, highest, _) = triangles[0], triangles[-1]
    return 2.0 * lowest - right, 2.0 * highest - left


def spread(table: RuleTable) -> tuple[float, float]:
    """Return the range of the weighted averages of a table; it is never empty."""
    values = [value for row in table for value in row]
    lowest, highest = min(values), max(values)
    return (lowest, highest) if lowest < highest else (lowest - 1.0, highest + 1.0)


def numbered(row: int, column: int) -> str:
    """Return a name for the singleton of a rule without a name, from the indices of its terms."""
    return f"u{row + 1}_{column + 1}"


def identifier(name: str) -> str:
    """Return a name of a design file as an identifier that every target language accepts."""
    return "".join(c if c.isascii() and c.isalnum() else "_" for c in name)


def rows_of(
    corner: str,
    row_labels: Sequence[str],
    column_labels: Sequence[str],
    table: Iterable[Iterable[object]],
    text: Callable[[object], str] = repr,
) -> Rows:
    """Return the rows of a CSV file: a rule table with its labels, and a text in the corner."""
    rows = [[label, *map(text, row)] for label, row in zip(row_labels, table, strict=True)]
    return [[corner, *column_labels], *rows]


def side(name: str, value: float, labels: Sequence[str], degrees: Iterable[float]) -> Json:
    """Return an input of a unit in a sample: its name, its value and the degrees of its terms."""
    pairs = zip(labels, map(float, degrees), strict=True)
    return {"input": name, "value": float(value), "degrees": dict(pairs)}


def fired(
    name: str,
    column: Json,
    row: Json,
    table: RuleTable,
    output: float,
    labels: Sequence[Sequence[str]] | None = None,
) -> Json:
    """Return a unit in a sample: inputs (from ``side``), output, firing rules, strongest first."""
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
            **({"label": labels[i][j]} if labels is not None else {}),
        }
        for i, j in zip(*np.nonzero(strength), strict=True)
    ]
    rules.sort(key=lambda rule: -rule["strength"])
    return {"unit": name, "column": column, "row": row, "rules": rules, "output": float(output)}
