"""Steps a design file in pure numpy, as a machine's control would. Never imports JAX.

>>> controller = load("design.json")                                    # doctest: +SKIP
>>> voltage = controller.step({"error": 1e-3, "error_rate": 0.0, ...})  # doctest: +SKIP
"""

from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.aflc import law as aflc
from hfc_design.controllers.aflc.adaptation import blamed_aflc, blamed_soflc
from hfc_design.controllers.flc import law as flc
from hfc_design.controllers.flc.record import (
    AflcDesign,
    FeedDesign,
    FlcDesign,
    PidDesign,
    SoflcDesign,
    Triangles,
)
from hfc_design.controllers.hierarchical import root as root_unit
from hfc_design.controllers.pid import law as pid
from hfc_design.files.design import Design, HierarchicalDesign, LawDesign, PdDesign, read_design

PREVIOUS = "previous_"


class Firing(NamedTuple):
    """What one unit of a hierarchy does at a sample."""

    column: float  # its inputs, an input of the hierarchy clamped to [-1, 1]
    row: float
    in_column: np.ndarray  # (7,) degrees
    in_row: np.ndarray  # (7,)
    table: np.ndarray  # (7, 7) consequents [row][column] as they are at this sample
    output: float


class HierarchyParts(NamedTuple):
    """What the command of a hierarchy is made of."""

    readings: list[float]  # of each input
    scaled: list[float]
    units: list[Firing]
    proportional: float
    derivative: float
    fuzzy: float  # the root's output, scaled

    def command(self) -> float:
        """The sum (LL eq. 6)."""
        return self.proportional + self.derivative + self.fuzzy


class Controller:
    """A controller that remembers what it has to from one sample to the next."""

    def __init__(self, design: Design):
        self.design = design.controller
        self._previous: dict[str, float] = {}
        if not isinstance(self.design, PdDesign | HierarchicalDesign):
            self._initial, self._law = _law(self.design)
            self._memory = self._initial
        elif isinstance(self.design, HierarchicalDesign):
            terms = self.design.terms
            self._centres = np.array([term.centre for term in terms])
            self._half_widths = np.array([term.half_width for term in terms])
            self._rates = np.array([term.rate for term in terms])
            self._tables = [np.array(unit.consequents) for unit in self.design.units]
            self._sources = self.design.sources()
            self._adaptation = _adaptation(self.design)
            self._root = root_unit.initial_memory(0.0)

    def step(self, signals: dict[str, float]) -> float:
        """The command for this sample's ``signals``.

        A C-axis takes volts for error [rad], error_rate [rad/s], ...; a feed drive takes units of
        its converter for error [BLU] and, with low-velocity compensation, velocity [BLU/s].

        Raises:
            KeyError: a signal that the design reads is missing.
        """
        design = self.design
        if isinstance(design, PdDesign):
            return float(design.pd.kp * signals["error"] + design.pd.kd * signals["error_rate"])
        if isinstance(design, PidDesign | LawDesign):
            command, self._memory = self._law(self._memory, signals)
            return float(command)
        return float(self.parts(signals).command())

    def parts(self, signals: dict[str, float]) -> HierarchyParts | flc.Parts:
        """Step, and say what the command is made of.

        Raises:
            KeyError: a signal that the design reads is missing.
            ValueError: the controller has no rules.
        """
        if isinstance(self.design, HierarchicalDesign):
            return self._hierarchy(self.design, signals)
        if isinstance(self.design, PdDesign | PidDesign | LawDesign):
            raise ValueError(f"a controller of kind {self.design.kind} has no rules")
        found: flc.Parts
        found, self._memory = self._law(self._memory, signals)
        return found

    def remember(self, readings: dict[str, float]) -> None:
        """Take ``readings`` for those of the sample before; the rest of the memory stays."""
        if isinstance(self.design, HierarchicalDesign):
            self._previous |= readings
        elif not isinstance(self.design, PdDesign):
            self._memory = self._memory._replace(**readings)

    def reset(self) -> None:
        """Forget the past, as before the first sample."""
        self._previous = {}
        if not isinstance(self.design, PdDesign | HierarchicalDesign):
            self._memory = self._initial
        elif isinstance(self.design, HierarchicalDesign):
            self._root = root_unit.initial_memory(0.0)

    def adapted(self) -> AflcDesign | SoflcDesign:
        """The controller with its terms and its rule table as they are by now.

        Raises:
            ValueError: it is of a kind that does not adapt.
        """
        record = self.design
        if not isinstance(record, AflcDesign | SoflcDesign):
            raise ValueError(f"a controller of kind {record.kind} does not adapt")
        error_terms, change_terms, table = aflc.current(record.gains(), self._memory)
        rules = record.rules.model_copy(update={"centroids": tuple(map(tuple, table))})
        changes = {
            "error_terms": _with_edges(record.error_terms, error_terms),
            "error_change_terms": _with_edges(record.error_change_terms, change_terms),
            "rules": rules,
        }
        return record.model_copy(update=changes)

    def _hierarchy(self, design: HierarchicalDesign, signals: dict[str, float]) -> HierarchyParts:
        readings = []
        for item in design.inputs:
            earlier = item.name.startswith(PREVIOUS)
            name = item.name.removeprefix(PREVIOUS)
            readings.append(self._previous.get(name, 0.0) if earlier else signals[name])
        scaled = [item.scale * x for item, x in zip(design.inputs, readings, strict=True)]
        values = [min(max(u, -1.0), 1.0) for u in scaled]
        units = []
        root = len(self._tables) - 1
        for k, (column, row) in enumerate(self._sources):
            table = self._tables[k]
            degrees = self._memberships(values[column]), self._memberships(values[row])
            if k == root and self._adaptation is not None:
                table = self._adapted(self._adaptation, table, *degrees, signals["error"])
            output = _averaged(table, *degrees)
            units.append(Firing(values[column], values[row], *degrees, table, output))
            values.append(output)
        for item in design.inputs:
            if item.name.startswith(PREVIOUS):
                name = item.name.removeprefix(PREVIOUS)
                self._previous[name] = signals[name]
        proportional = design.pd.kp * signals["error"]
        derivative = design.pd.kd * signals["error_rate"]
        fuzzy = design.output_scale * values[-1]
        return HierarchyParts(readings, scaled, units, proportional, derivative, fuzzy)

    def _adapted(
        self,
        law: root_unit.Adaptation,
        table: np.ndarray,
        in_column: np.ndarray,
        in_row: np.ndarray,
        error: float,
    ) -> np.ndarray:
        """The root's table, once the previous sample is judged by the ``error`` of this one."""
        assert law.error_scale is not None
        in_error = self._memberships(min(max(law.error_scale * error, -1.0), 1.0))
        degrees = (part.tolist() for part in (in_error, in_column, in_row))
        adapted, self._root = root_unit.step(flc.SCALARS, law, table.tolist(), self._root, *degrees)
        return np.array(adapted)

    def _memberships(self, u: float) -> np.ndarray:
        """Degrees to which ``u`` belongs to the seven terms (LL eq. 3)."""
        distance = np.maximum(np.abs(u - self._centres) - self._half_widths, 0.0)
        return np.exp(-self._rates * distance * distance)


def _averaged(table: np.ndarray, in_column: np.ndarray, in_row: np.ndarray) -> float:
    """Output of one unit (LL eq. 4); 0 where no rule fires."""
    firing = in_column.sum() * in_row.sum()
    return float(in_row @ table @ in_column / firing) if firing > 0.0 else 0.0


def _adaptation(design: HierarchicalDesign) -> root_unit.Adaptation | None:
    """How the root adapts, with the scale of the error."""
    if design.adaptation is None:
        return None
    scales = {item.name: item.scale for item in design.inputs}
    law = design.adaptation.law()
    return law._replace(error_scale=law.error_scale or scales["error"])


def _with_edges(terms: Triangles, moved: Any) -> Triangles:
    """Terms with other edges; those at infinity stay there."""
    return tuple(
        term.model_copy(
            update={
                "left": None if term.left is None else left,
                "right": None if term.right is None else right,
            }
        )
        for term, (left, _, right) in zip(terms, moved, strict=True)
    )


def _law(record: FeedDesign | LawDesign) -> tuple[Any, Any]:
    """Memory before the first sample, and the simulator's step or its parts on Python floats."""
    every = record.sample_time_s
    if isinstance(record, LawDesign):
        return record.law.initial_memory(0.0), partial(record.law.step, every, record.values())
    if isinstance(record, PidDesign):
        return pid.initial_memory(0.0), partial(pid.step, every, record.gains())
    if isinstance(record, FlcDesign):
        law = partial(flc.parts, flc.SCALARS, record.form, every, record.gains())
        return flc.initial_memory(0.0), law
    blamed = blamed_aflc if isinstance(record, AflcDesign) else blamed_soflc
    return aflc.initial_memory(0.0), partial(aflc.parts, flc.SCALARS, blamed, every, record.gains())


def load(path: str | Path) -> Controller:
    """The controller of a design file.

    Raises:
        UserError: the file is not a design that can run.
    """
    return Controller(read_design(path))
