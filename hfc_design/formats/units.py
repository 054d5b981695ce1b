"""What every format is written from: a design's rule tables, and facts for the file's head.

Nothing that a user wrote freely gets into a generated file: names and labels are identifiers
(``rulebase.Label``, ``records.Name``), everything else is a number.
"""

import hashlib
import math
import re
from typing import NamedTuple

from hfc_design import __version__
from hfc_design.controllers.flc.record import FuzzyRecord, TriangleRecord
from hfc_design.core.records import Table, UserError
from hfc_design.files.design import (
    BuiltInDesign,
    Design,
    HierarchicalDesign,
    LawDesign,
    TermRecord,
    design_json,
)

#: Plant -> unit of its error and of its command.
UNITS = {"c-axis": ("rad", "V"), "feed-drive": ("BLU", "unit")}


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
    table: Table  # [row term][column term]


def rule_units(design: Design) -> list[RuleUnit]:
    """The units in evaluation order, the last one gives the output.

    Inputs of a hierarchy are scaled and clamped to [-1, 1] before they enter.

    Raises:
        UserError: the design is of a kind without rule tables.
    """
    controller = design.controller
    if isinstance(controller, HierarchicalDesign):
        terms = tuple(map(_flat, controller.terms))
        return [
            RuleUnit(
                f"unit_{unit.id}",
                identifier(unit.column_input),
                identifier(unit.row_input),
                terms,
                terms,
                unit.consequents,
            )
            for unit in controller.units
        ]
    if isinstance(controller, FuzzyRecord):
        error, change = (
            tuple(map(_triangle, part))
            for part in (controller.error_terms, controller.error_change_terms)
        )
        table = controller.rules.centroids
        return [RuleUnit("rules", "error_change", "error", change, error, table)]
    raise UserError(f"design {design.name} is of kind {controller.kind}: no rule tables")


def built_in(design: Design) -> BuiltInDesign:
    """The controller of ``design``.

    Raises:
        UserError: it is of a user's own kind; its law is Python code, which no format can hold.
    """
    controller = design.controller
    if isinstance(controller, LawDesign):
        raise UserError(
            f"design {design.name} is of the own kind {controller.kind}: json holds its gains, "
            "its law is in Python only"
        )
    return controller


def identifier(name: str) -> str:
    """A name of a design file as an identifier of every target."""
    return "".join(c if c.isascii() and c.isalnum() else "_" for c in name)


def facts(design: Design) -> list[str]:
    """Lines for the head of a file: what made it, and from which design."""
    digest = hashlib.sha256(design_json(design).encode()).hexdigest()
    controller = design.controller
    return [
        f"made by hfc-design {__version__}",
        f"design {design.name}, sha256 {digest}",
        f"controller {controller.kind} for the plant {design.plant.name}, "
        f"stepped every {controller.sample_time_s!r} s",
    ]


def comment(lines: list[str]) -> list[str]:
    """Lines for a comment or a string; nothing in them can end it."""
    return [re.sub(r"[^A-Za-z0-9 .,:;_+-]", "_", line) for line in lines]


def _flat(term: TermRecord) -> FlatGaussian:
    low, high = term.centre - term.half_width, term.centre + term.half_width
    return FlatGaussian(term.label, low, high, 1.0 / math.sqrt(2.0 * term.rate))


def _triangle(term: TriangleRecord) -> Triangle:
    left = -math.inf if term.left is None else term.left
    right = math.inf if term.right is None else term.right
    return Triangle(term.label, left, term.centre, right)
