"""A folder with one file of a fuzzy language a unit: what FLL, FCL and FML have in common."""

import math
from collections.abc import Collection
from pathlib import Path
from typing import Any, NamedTuple

from hfc_design.controllers.rules import RuleUnit, Term, Triangle
from hfc_design.core.records import Table
from hfc_design.files.design import Design
from hfc_design.formats.manifest import distinct, surroundings
from hfc_design.formats.units import comment, facts, rule_base
from hfc_design.formats.writing import rendered, write_folder


class Input(NamedTuple):
    """An input of a unit."""

    name: str
    terms: tuple[Term, ...]
    lowest: float
    highest: float
    clamped: bool  # what is beyond lowest and highest counts as these; else it counts as it is


class Rule(NamedTuple):
    """If the row input is ``row`` and the column input is ``column`` then ``value``."""

    name: str  # of its singleton: a singleton a rule, so that no reader merges two of them
    row: str
    column: str
    value: float


def texts(
    design: Design, target: str, suffix: str, reserved: Collection[str], **values: Any
) -> dict[str, str]:
    """The files of the folder by name; a unit is written by ``unit.SUFFIX.j2`` with ``values``.

    Raises:
        UserError: the design has no rule tables, or a name is a word of ``reserved``.
    """
    units = distinct(design, target, reserved)
    tables = {unit.name: unit.table for unit in units}
    files = {}
    for unit in units:
        row, column = inputs(unit, tables)
        lowest, highest = _range(unit.table)
        files[f"{unit.name}.{suffix}"] = rendered(
            f"unit.{suffix}.j2",
            design,
            unit=unit,
            inputs=(row, column),
            rules=_rules(unit),
            lowest=lowest,
            highest=highest,
            head=head(design),
            infinity=math.inf,
            **values,
        )
    return files | surroundings(design, suffix)


def write(
    design: Design, path: Path, target: str, suffix: str, reserved: Collection[str], **values: Any
) -> None:
    """Write ``texts`` into the folder ``path``.

    Raises:
        UserError: as ``texts``.
        RunError: the folder cannot be written.
    """
    write_folder(path, texts(design, target, suffix, reserved, **values))


def inputs(unit: RuleUnit, tables: dict[str, Table]) -> tuple[Input, Input]:
    """Row and column input; ``tables`` are those of all units by name."""
    row = _input(unit.row, unit.row_terms, tables.get(unit.row))
    return row, _input(unit.column, unit.column_terms, tables.get(unit.column))


def _input(name: str, terms: tuple[Term, ...], source: Table | None) -> Input:
    first, last = terms[0], terms[-1]
    if isinstance(first, Triangle) and isinstance(last, Triangle):
        lowest = 2.0 * first.centre - first.right
        return Input(name, terms, lowest, 2.0 * last.centre - last.left, clamped=False)
    if source is None:
        return Input(name, terms, -1.0, 1.0, clamped=True)
    lowest, highest = _range(source)
    return Input(name, terms, min(lowest, -1.0), max(highest, 1.0), clamped=False)


def _range(table: Table) -> tuple[float, float]:
    """What a weighted average of the table can be, and some room if that is one number."""
    values = [value for row in table for value in row]
    lowest, highest = min(values), max(values)
    return (lowest, highest) if lowest < highest else (lowest - 1.0, highest + 1.0)


def _rules(unit: RuleUnit) -> list[Rule]:
    return [
        Rule(f"u{i}_{j}", row.label, column.label, unit.table[i - 1][j - 1])
        for i, row in enumerate(unit.row_terms, 1)
        for j, column in enumerate(unit.column_terms, 1)
    ]


def head(design: Design) -> list[str]:
    """What made a unit's file, and what it leaves out."""
    return comment([*facts(design), *rule_base(design).notes(design.controller)])
