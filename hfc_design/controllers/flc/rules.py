"""Rule table of a fuzzy controller: a label and a number for each rule. Never imports JAX."""

import sys
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Annotated, Self, cast

import numpy as np
from pydantic import Field, model_validator

from hfc_design.core.numbers import Floats, Json, Plain, RuleTable
from hfc_design.core.records import Finite, Label, Record
from hfc_design.core.wording import one_of

#: Smallest and largest number of terms of an input of a rule table.
FEWEST, MOST = 2, 11
#: Linguistic labels, negative large to positive large.
LABELS = ("NL", "NM", "NS", "ZR", "PS", "PM", "PL")
#: JK04 Table 3: centroid of each label in units of the command.
CENTROIDS = (-32.0, -16.0, -8.0, 0.0, 8.0, 16.0, 32.0)
Labels = tuple[Annotated[tuple[Label, ...], Field(min_length=FEWEST, max_length=MOST)], ...]
LabelTable = Annotated[Labels, Field(min_length=FEWEST, max_length=MOST)]
Heights = tuple[Annotated[tuple[Finite, ...], Field(min_length=FEWEST, max_length=MOST)], ...]
HeightTable = Annotated[Heights, Field(min_length=FEWEST, max_length=MOST)]


class RulesRecord(Record):
    """Rule table: rows by terms of the error, columns by terms of its change, the lowest first.

    With ``output_terms``, the number of a rule is that of its label, and the numbers may be left
    out. Without, the labels are the seven usual ones; a larger label must have a larger number,
    and the labels may be left out.
    """

    labels: LabelTable  # name of the output term of each rule
    centroids: HeightTable  # output of each rule, in units of the command [command]
    #: output terms by name [command]; left out: each rule has its own number
    output_terms: dict[Label, Finite] | None = Field(None, exclude_if=lambda terms: terms is None)

    @model_validator(mode="before")
    @classmethod
    def _completed(cls, data: Plain) -> Plain:
        if not isinstance(data, dict):
            return data
        labels: Plain = data.get("labels")
        table: Plain = data.get("centroids")
        try:
            if labels is None and data.get("output_terms") is None:
                return {**data, "labels": nearest_labels(table)}
            if table is not None:
                return data
            terms = data["output_terms"]
            fault = _unnamed(labels, terms)
            table = fault or [[terms[label] for label in row] for row in labels]
        except (KeyError, TypeError, ValueError):
            return data  # the fields say what is wrong
        if fault:
            raise ValueError(fault)
        return {**data, "centroids": table}

    @model_validator(mode="after")
    def _labels_name_numbers(self) -> Self:
        rows, needed = ([len(row) for row in table] for table in (self.labels, self.centroids))
        if uneven := next((i for i, count in enumerate(needed) if count != needed[0]), None):
            message = f"must have {needed[0]} entries, like row 0 (got {needed[uneven]})"
            raise ValueError(f"centroids.{uneven}: {message}")
        if rows != needed:
            shape = f"{len(needed)} x {needed[0]}"
            raise ValueError(f"labels: must have the shape of centroids, {shape}")
        terms = self.output_terms
        if fault := _unnamed(self.labels, LABELS if terms is None else terms):
            raise ValueError(fault)
        for i, (row, numbers) in enumerate(zip(self.labels, self.centroids, strict=True)):
            for j, (label, number) in enumerate(zip(row, numbers, strict=True)):
                if terms is not None and terms[label] != number:
                    message = f"must be {terms[label]}, which its label {label!r} stands for"
                    hint = f"or change labels.{i}.{j}, or output_terms.{label}"
                    raise ValueError(f"centroids.{i}.{j} = {number}: {message}; {hint}")
        return self

    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return len(self.centroids), len(self.centroids[0])

    def contradiction(self) -> str | None:
        """Return a message on two rules whose labels and numbers have opposite orders, or None."""
        if self.output_terms is not None:
            return None  # each label has one number
        by_label = defaultdict(list)
        for i, row in enumerate(self.labels):
            for j, label in enumerate(row):
                by_label[label].append((self.centroids[i][j], i, j))
        highest, below = (-np.inf, 0, 0), ""
        for label in filter(by_label.__contains__, LABELS):
            lowest = min(by_label[label])
            if highest[0] > lowest[0]:
                return _text(below, highest, label, lowest)
            highest, below = max(by_label[label]), label
        return None

    def moved(self, table: RuleTable) -> Self:
        """Return the rules with the numbers of ``table`` and with labels that fit them."""
        rows = tuple(tuple(map(float, row)) for row in table)
        rules = self.model_copy(update={"centroids": rows, "output_terms": None})
        unfit = self.output_terms is not None or rules.contradiction()
        return rules.relabelled() if unfit else rules

    def relabelled(self) -> Self:
        """Return the rules with the same numbers and the labels of ``nearest_labels``."""
        rows = tuple(map(tuple, nearest_labels(self.centroids)))
        return self.model_copy(update={"labels": rows})


Cell = tuple[float, int, int]


def _text(low: str, higher: Cell, high: str, lower: Cell) -> str:
    (a, i, j), (b, m, n) = higher, lower
    pair = f"labels.{i}.{j} = {low!r} is {a:g} and labels.{m}.{n} = {high!r} is {b:g}"
    needed = "a larger label must have a larger centroid"
    return f"{pair}: {needed}; if left out, labels follow from the centroids"


def _unnamed(labels: Iterable[Iterable[str]], known: Iterable[str]) -> str | None:
    """Return a message on the first label that is not among ``known``, or None."""
    names = [*known]
    for i, row in enumerate(labels):
        for j, label in enumerate(row):
            if label not in names:
                unknown = f"unknown output term; {one_of(str(label), names)}"
                return f"labels.{i}.{j} = {label!r}: {unknown}"
    return None


def unused_term(rules: Json, keys: Iterable[str]) -> str | None:
    """Return a message on the first changed key of an output term that no rule has, or None.

    Without this check a mistyped name would silently be one more term.
    """
    labels: Plain = rules.get("labels")
    if not isinstance(labels, list):
        return None  # the fields say what is wrong
    used = {str(x): None for row in labels if isinstance(row, list) for x in row}
    for key in keys:
        _, start, name = key.partition("rules.output_terms.")
        if start and name not in used:
            known = one_of(name, used, "the rules use")
            return f"{key}: must be the output term of a rule; {known}"
    return None


def nearest_labels(table: Sequence[Sequence[float]]) -> list[list[str]]:
    """Return the label of the nearest centroid for each number, all in shares of the largest."""
    heights: Floats = np.array(table, dtype=np.float64)
    shares = heights / max(np.abs(heights).max(), sys.float_info.min)
    off = np.abs(shares[..., None] - np.array(CENTROIDS) / CENTROIDS[-1])
    nearest = np.round(off, 9).argmin(axis=-1)  # of two equally near ones the first
    return [[LABELS[k] for k in row] for row in cast(Floats, nearest)]
