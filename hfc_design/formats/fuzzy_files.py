"""Folders with one file per rule unit: the common part of FLL, FCL, FML and FIS.

The formats FLL and FML are registered here.

In each folder ``manifest.csv`` lists the units in evaluation order, with the inputs of each.
``controller.json`` holds everything else that the command depends on: scales, limits, gains, and
the steps of one sample in words.
"""

import json
import math
import xml.etree.ElementTree as ET
from collections import Counter
from contextlib import suppress
from functools import partial
from typing import NamedTuple

from hfc_design.controllers.rules import (
    RuleUnit,
    Term,
    Triangle,
    identifier,
    numbered,
    range_of,
    spread,
)
from hfc_design.core.numbers import Json, RuleTable
from hfc_design.core.records import UserError, option
from hfc_design.files.design import Design
from hfc_design.formats import writing
from hfc_design.formats.scripts import function
from hfc_design.formats.writing import Format

CLASH = "{name!r} is a keyword of that format, or the same as another name there"


class Input(NamedTuple):
    """Input of a unit."""

    name: str
    terms: tuple[Term, ...]
    lowest: float
    highest: float
    clamped: bool  # whether a value beyond lowest or highest counts as that bound


class Rule(NamedTuple):
    """Rule: if the row input is ``row`` and the column input is ``column`` then ``value``."""

    name: str  # of its singleton; without labels each rule has one, so readers merge none
    row: str
    column: str
    value: float


def texts(design: Design, target: str, **values: object) -> dict[str, str]:
    """Return file name -> text of the folder of a format; units are rendered with ``values``.

    Raises:
        UserError: the design has no rule tables, or a name is not allowed in the format.
    """
    suffix = target.partition("-")[0]  # a dialect has the suffix of its language
    units = writing.rule_units(design)
    signals = [identifier(name) for name in writing.rule_base(design).inputs(design.controller)]
    writing.check_names(target, [*signals, *(unit.name for unit in units)], CLASH)
    for terms in (units[0].row_terms, units[0].column_terms):
        writing.check_names(target, [term.label for term in terms], CLASH)
    values |= {"head": unit_head(design), "infinity": math.inf, "target": target}
    files, read = {}, inputs(units)
    rows = [["unit", "column_input", "row_input", "file"]]
    for unit in units:
        least = spread(unit.table)
        lowest, highest = _represented(unit, unit.name, least) or least
        rules = _rules(unit)
        singletons = {rule.name: rule.value for rule in rules}  # a shared name occurs once
        writing.check_names(target, singletons, CLASH)
        values |= {"lowest": lowest, "highest": highest, "rules": rules, "unit": unit}
        values |= {"singletons": singletons, "engine": unit.engine or unit.name}
        name = f"{unit.name}.{suffix}"
        files[name] = writing.rendered(
            f"unit.{suffix}.j2", design, inputs=read[unit.name], **values
        )
        rows.append([unit.name, unit.column, unit.row, name])
    files["manifest.csv"] = writing.csv_text(rows)
    with suppress(UserError):  # left out if a number is too large for code
        files["controller.m"] = function(design, "controller")
    files["controller.json"] = json.dumps(companion_files(design), indent=1, allow_nan=False) + "\n"
    return files


def companion_files(design: Design) -> Json:
    """Return the content of ``controller.json``: what the command depends on besides the units."""
    units = writing.signal_units(design)
    about = writing.rule_base(design).about(design.controller, units)
    if design.limits.command is not None:
        about = about | {"largest_command": design.limits.command}
    if (change := design.changes([design.axis])[design.axis]) is not None:
        about = about | {"largest_change": change}
    head = {"facts": writing.facts(design), "sample_time_s": design.controller.sample_time_s}
    return {**head, "command_unit": units.get("command", ""), **about}


def inputs(units: list[RuleUnit]) -> dict[str, tuple[Input, Input]]:
    """Return name of a unit -> its row input and its column input."""
    tables = {unit.name: unit.table for unit in units}
    return {
        x.name: (_input(x, x.row, x.row_terms, tables), _input(x, x.column, x.column_terms, tables))
        for x in units
    }


def _input(
    unit: RuleUnit, name: str, terms: tuple[Term, ...], tables: dict[str, RuleTable]
) -> Input:
    triangles = [term[1:] for term in terms if isinstance(term, Triangle)]
    if triangles:
        centres = triangles[0][1], triangles[-1][1]
        ends = _represented(unit, name, centres) or range_of(triangles)
        return Input(name, terms, *ends, clamped=False)
    if name not in tables:
        return Input(name, terms, -1.0, 1.0, clamped=True)
    lowest, highest = spread(tables[name])
    return Input(name, terms, min(lowest, -1.0), max(highest, 1.0), clamped=False)


def _represented(
    unit: RuleUnit, name: str, least: tuple[float, float]
) -> tuple[float, float] | None:
    """Return the imported range of variable ``name``; None if it does not cover ``least``."""
    lowest, highest = unit.ranges.get(name, (math.inf, -math.inf))
    return (lowest, highest) if lowest <= least[0] and least[1] <= highest else None


def _rules(unit: RuleUnit) -> list[Rule]:
    def singleton(i: int, j: int) -> str:
        return numbered(i, j) if unit.labels is None else unit.labels[i][j]

    return [
        Rule(singleton(i, j), row.label, column.label, unit.table[i][j])
        for i, row in enumerate(unit.row_terms)
        for j, column in enumerate(unit.column_terms)
    ]


def unit_head(design: Design) -> list[str]:
    """Return the head comment of a unit's file: its origin, and what the file leaves out."""
    return writing.head(design, writing.rule_base(design).notes(design.controller))


def fml(design: Design) -> dict[str, str]:
    """Return FML for JFML, one system per unit; UserError: a file would have a name twice."""
    files = texts(design, "fml", domain=_domain)
    for file, text in files.items():
        if not file.endswith(".fml"):
            continue
        # Names are XML IDs: variables, terms and rules of a file must all have different ones.
        names = Counter(element.get("name") for element in ET.fromstring(text.encode()).iter())
        for name, count in names.items():
            if name is not None and count > 1:
                fault = f"{file} would contain {name} twice; rename the signal, unit or term {name}"
                raise UserError(f"{option('to', 'fml')}: {fault}")
    return files


def _domain(place: Input) -> tuple[float, float]:
    """Return the range of an input in JFML, which refuses other values: wide if not clamped."""
    if place.clamped:
        return place.lowest, place.highest
    room = 1e6 if isinstance(place.terms[0], Triangle) else 1.0
    return place.lowest - room, place.highest + room


FLL = "a folder with FuzzyLite Language, one engine per unit"
FML = "a folder with Fuzzy Markup Language (IEEE 1855), one system per unit"
FORMATS = (Format("fll", FLL, partial(texts, target="fll")), Format("fml", FML, fml))
