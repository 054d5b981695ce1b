"""Runs a design in plain numbers, sample by sample, as a control does. Never imports JAX.

>>> controller = load("design.json")                                    # doctest: +SKIP
>>> voltage = controller.step({"error": 1e-3, "error_rate": 0.0, ...})  # doctest: +SKIP

A sample is faulty if a reading or the output of the law is not finite. The command is then NaN,
and the next sample continues as if the faulty one had not occurred. Before the first sample the
axis is assumed to have been at the same readings, so that no change of a signal causes a kick.
Generated code does the same, but in Structured Text and HAL a fault gives the command 0.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from math import isfinite, isnan, nan
from numbers import Real
from pathlib import Path
from typing import Any

from hfc_design.controllers import controller
from hfc_design.controllers.controller import AxisLaw, PathView, Signals, View
from hfc_design.controllers.kind import ControllerRecord, require
from hfc_design.core.arguments import a_kind
from hfc_design.core.numbers import SCALARS, Memory, Parameters, finite
from hfc_design.core.plugins import use as use  # registers an own kind, as "module:OBJECT"
from hfc_design.core.records import UserError
from hfc_design.core.validation_errors import short
from hfc_design.files.design import AnyDesign, Design, learned, named_design

#: Exceptions of a step that invalid input causes.
WRONG = KeyError, TypeError, AttributeError


class Missing(UserError, KeyError):
    """Error for a missing signal or axis; also a KeyError, which scripts may expect."""


def what_is_wrong(given: Iterable[Any], error: Exception, what: str = "signal") -> Exception:
    """Return the exception for a step that failed with ``error``: the same if input is valid.

    The input is examined only after a step has failed.

    ``given`` are mappings of names to readings, or to the signals of an axis if ``what`` is "axis".
    """
    for one in given:
        if not isinstance(one, dict) and not hasattr(one, "keys"):
            return UserError(f"argument must be a mapping of names to readings (got {a_kind(one)})")
        if isinstance(error, KeyError) and error.args[0] not in one:
            return Missing(f"the {what} {error} is missing (got {', '.join(one) or 'none'})")
        for name, x in one.items():
            if what == "signal" and not isinstance(x, Real):
                return UserError(f"{name} = {short(x)}: must be a number")
    return error


def reader(kind: type[ControllerRecord], record: ControllerRecord) -> Callable[[Signals], bool]:
    """Return a test whether the signals that a law reads are finite; if unknown, all given."""
    if not (names := kind.reads(record) if kind.reads else []):
        return finite

    def reads(signals: Signals) -> bool:
        try:
            return all(map(isfinite, map(signals.__getitem__, names)))
        except KeyError:  # the law's own error names the signal
            return finite(signals)

    return reads


class Controller:
    """Controller of one axis, with its memory from one sample to the next.

    ``axis`` is needed if axes have different controllers or limits. ``law``, for example one with
    tabulated terms, is used with the same numbers in place of the law of the kind.
    """

    def __init__(self, design: AnyDesign, axis: str = "", law: AxisLaw | None = None):
        whole = named_design(design)
        self._whole = design = whole.by_axis().get(axis, whole)
        kind = design.kind
        self.design = design.controller
        made = require(
            kind.law, design, "it commands a whole machine: name an axis, or use runtime.Machine"
        )
        named = axis or design.axis
        limit = design.limits.of(named).command
        self._law: AxisLaw = law or made(self.design, limit)
        self._gains = self.design.law_gains()
        self._sample = partial(self._law.sample, SCALARS, self._law, self._gains)
        self._limited = partial(controller.limited, SCALARS, self._law.limit)
        self._ramped = partial(controller.ramped, SCALARS, design.changes([named])[named])
        self._reads = reader(kind, self.design)
        self._memory: Memory = None
        self._command = 0.0  # of the sample before
        self.reset()

    def step(self, signals: Signals) -> float:
        """Return the command for this sample's ``signals``; NaN if the sample is faulty.

        For a C-axis the command is in volts, from error [rad], error_rate [rad/s], ...; for a feed
        drive it is in units of the converter, from error [BLU] and perhaps velocity [BLU/s].

        Raises:
            KeyError: a signal that the design reads is missing; the exception is a UserError too.
            UserError: ``signals`` is not a mapping, or a reading is not a number.
        """
        return self.step_in_parts(signals)[0]

    def step_in_parts(self, signals: Signals) -> tuple[float, Any]:
        """Return the command for this sample's ``signals`` and its components.

        The components are None if the kind does not provide them, or the sample is faulty.

        Raises:
            KeyError: a signal that the design reads is missing; the exception is a UserError too.
            UserError: ``signals`` is not a mapping, or a reading is not a number.
        """
        command, memory, parts = self._tried(signals)
        self._done(command, memory)
        return command, parts

    def _tried(self, signals: Signals) -> tuple[float, Memory, Any]:
        """Return command, new memory and components; NaN, old memory and None if faulty."""
        try:
            if self._reads(signals):
                memory = self._memory
                if self._fresh:
                    memory = self._law.primed(SCALARS, self._gains, memory, signals)
                command, memory, parts = self._sample(memory, signals)
                if isfinite(command) and (self._law.tells or finite(memory)):
                    command = self._ramped(self._command, self._limited(command))
                    return float(command), memory, parts
        except ArithmeticError:  # in other languages a division by zero is infinite
            pass
        except WRONG as error:
            raise what_is_wrong([signals], error) from None
        return nan, self._memory, None

    def _done(self, command: float, memory: Memory) -> None:
        """Store memory and command after a sample; a faulty one (command NaN) changes nothing."""
        self._memory = memory
        if not isnan(command):
            self._command, self._fresh = command, False

    def remember(self, readings: dict[str, float]) -> None:
        """Set ``readings`` as those of the previous sample; ValueError: one is not finite."""
        if not finite(readings):
            raise ValueError(f"{readings}: must be finite")
        explain = require(
            self._whole.kind.explain, self._whole, "it cannot be set to an earlier state"
        )
        self._memory = explain.remember(self._memory, readings)
        self._fresh = self._fresh and not readings

    def reset(self) -> None:
        """Reset the memory to the state before the first sample."""
        self._memory, self._command = self._law.begun(SCALARS, 0.0, self._gains), 0.0
        self._fresh = True

    def adapted(self) -> ControllerRecord:
        """Return the controller's record with its present adapted values.

        Raises:
            ValueError: the kind does not adapt.
        """
        adapted = self._whole.kind.adapted
        if adapted is None or (record := adapted(self.design, self._memory)) is None:
            raise ValueError(f"a controller of kind {self.design.kind} does not adapt")
        return record


class Machine:
    """Controllers of all axes of a machine, also for kinds that read the whole machine.

    ``axes`` names them in order; default: those of the design's ``plant.axes``, or a single one.

    Raises:
        UserError: the design has limits of single axes, but nothing names all axes.
    """

    def __init__(self, design: AnyDesign, axes: tuple[str, ...] = ()):
        self.design = design = named_design(design)
        if (named := design.limits.axes) and not (axes or design.plant.axes):
            message = (
                f"{design.name}: limits.axes has {', '.join(named)}, but plant.axes is missing"
            )
            raise UserError(f"{message}; name all axes: Machine(design, ('x', 'y'))")
        self.axes = axes or tuple(design.plant.axes) or ("axis",)
        kind, self._controller = design.kind, design.commanding(self.axes)
        self._gains = design.controller.law_gains()
        self._reads = reader(kind, design.controller)
        self._memory: Memory = None
        self._fresh = True
        self._begin()
        #: Axis -> its controller, if no axis reads another one: a fault then stops only one axis.
        self._each: dict[str, Controller] = {}
        whole = self._controller
        inside = whole.inner if isinstance(whole, controller.RateLimited) else whole
        if isinstance(inside, controller.PerAxis) and (kind.law or kind.axis_records):
            self._each = {axis: Controller(design, axis) for axis in self.axes}

    def step(
        self,
        signals: Mapping[str, Signals],
        path: PathView | None = None,
        nominal: Parameters = None,
    ) -> dict[str, float]:
        """Return the command of every axis by its name, for the axes' signals at this sample.

        Only faulty axes have the command NaN. But if the controller reads the whole machine, all
        commands are NaN as soon as one axis is faulty or ``path`` is not finite.

        Raises:
            KeyError: an axis, or a signal that the design reads, is missing; the exception is a
                UserError too.
            UserError: ``signals`` is not a mapping, or a reading is not a number.
        """
        try:
            axes = tuple(signals[axis] for axis in self.axes)
        except WRONG as error:
            raise what_is_wrong([signals], error, "axis") from None
        if self._each:  # no memory changes before all are computed: a signal may be missing
            pairs = zip(self._each.items(), axes, strict=True)
            tried = {axis: one._tried(axis_signals) for (axis, one), axis_signals in pairs}
            for axis, (command, memory, _) in tried.items():
                self._each[axis]._done(command, memory)
            return {axis: command for axis, (command, *_) in tried.items()}
        commands = (nan,) * len(axes)
        try:
            if all(map(self._reads, axes)) and finite(path):
                view = View(axes, path, nominal)
                memory = self._memory
                if self._fresh:
                    memory = controller.primed(self._controller, SCALARS, self._gains, memory, view)
                raw_commands, memory = self._controller.step(SCALARS, self._gains, memory, view)
                if finite((raw_commands, memory)):
                    commands = tuple(map(float, raw_commands))
                    self._memory, self._fresh = memory, False
        except ArithmeticError:
            pass
        except WRONG as error:
            raise what_is_wrong(axes, error) from None
        return dict(zip(self.axes, commands, strict=True))

    def _begin(self) -> None:
        self._memory = controller.begun(self._controller, SCALARS, 0.0, self._gains)
        self._fresh = True

    def reset(self) -> None:
        """Reset the memory to the state before the first sample."""
        self._begin()
        for one in self._each.values():
            one.reset()

    def learned(self) -> Design:
        """Return the design with its learned values; axes get their own controllers if they differ.

        Raises:
            UserError: the kind does not adapt.
        """
        memory = tuple(one._memory for one in self._each.values()) or self._memory
        return learned(self.design, self.axes, memory, {})


def load(path: str | Path) -> Controller:
    """Return the controller of a design file, of a run folder or of a built-in design.

    Raises:
        UserError: the design does not exist, or cannot run.
    """
    return Controller(path)
