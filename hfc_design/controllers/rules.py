"""Rule tables in the form that every format and every explanation uses, for all kinds.

Names and labels are identifiers (``records.Label``, ``records.Name``), everything else is a
number, so that nothing a user wrote freely gets into a generated file. Never imports JAX.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Json, Own, RuleTable

Rows = list[list[str]]


class FlatGaussian(NamedTuple):
    """1 from ``low`` to ``high``, Gaussian tails of width ``sigma`` beyond them (LL eq. 3)."""

    label: str
    low: float
    high: float
    sigma: float


class Triangle(NamedTuple):
    """JK04 eq. 1; an outermost term is 1 beyond its centre, where its edge is infinite."""

    label: str
    left: float
    centre: float
    right: float


Term = FlatGaussian | Triangle


class RuleUnit(NamedTuple):
    """A two-input unit: product, weighted average of singletons."""

    name: str  # identifier
    column: str  # identifier of what it reads: a signal or an earlier unit
    row: str
    column_terms: tuple[Term, ...]
    row_terms: tuple[Term, ...]
    table: RuleTable  # [row term][column term]
    #: The same of names of singletons that rules share; None: each rule has one of its own.
    labels: Sequence[Sequence[str]] | None = None
    engine: str = ""  # identifier of the system of both inputs and the output; "": the name
    #: Of those inputs and outputs, by their names, that have had one where the unit comes from.
    ranges: Mapping[str, tuple[float, float]] = {}


class RuleBase(NamedTuple):
    """Rule tables and signals that a kind with rules gives to the formats."""

    #: Units in evaluation order, the last one gives the output.
    units: Callable[[Own], list[RuleUnit]]
    #: Names of the inputs, in the order in which the wiring numbers them.
    inputs: Callable[[Own], list[str]]
    #: (record, units of signals) -> what a command takes beside the units, steps in words.
    about: Callable[[Own, dict[str, str]], Json]
    #: What a reader of a unit's file has to know.
    notes: Callable[[Own], list[str]]
    #: Rule tables as CSV: name of a file -> its rows.
    tables: Callable[[Own], dict[str, Rows]]


def range_of(triangles: Sequence[tuple[float, float, float]]) -> tuple[float, float]:
    """Range of an input: its outermost centres, extended by the inner widths of their terms."""
    (_, lowest, right), (left, highest, _) = triangles[0], triangles[-1]
    return 2.0 * lowest - right, 2.0 * highest - left


def spread(table: RuleTable) -> tuple[float, float]:
    """Range of a weighted average of the table, widened if it is a single number."""
    values = [value for row in table for value in row]
    lowest, highest = min(values), max(values)
    return (lowest, highest) if lowest < highest else (lowest - 1.0, highest + 1.0)


def numbered(row: int, column: int) -> str:
    """Name of a rule's singleton that has none of its own, from the places of its terms."""
    return f"u{row + 1}_{column + 1}"


def identifier(name: str) -> str:
    """A name of a design file as an identifier that every target language accepts."""
    return "".join(c if c.isascii() and c.isalnum() else "_" for c in name)


def rows_of(
    corner: str,
    row_labels: Sequence[str],
    column_labels: Sequence[str],
    table: Iterable[Iterable[object]],
    text: Callable[[object], str] = repr,
) -> Rows:
    """A rule table with its labels."""
    rows = [[label, *map(text, row)] for label, row in zip(row_labels, table, strict=True)]
    return [[corner, *column_labels], *rows]


def side(name: str, value: float, labels: Sequence[str], degrees: Iterable[float]) -> Json:
    """An input of a unit at a sample: its value and the degrees of its terms."""
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
    """One unit with the rules that fire, the strongest first; its inputs are made by ``side``."""
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
