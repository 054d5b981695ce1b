"""Steps a design file in plain numbers, as a machine's control would. Never imports JAX.

>>> controller = load("design.json")                                    # doctest: +SKIP
>>> voltage = controller.step({"error": 1e-3, "error_rate": 0.0, ...})  # doctest: +SKIP
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from hfc_design.controllers.controller import AxisLaw, PathView, Signals, View, limited
from hfc_design.controllers.kind import ControllerRecord, needed
from hfc_design.core.numbers import SCALARS, Parameters
from hfc_design.core.plugins import use as use  # makes an own kind known, as "module:OBJECT"
from hfc_design.files.design import AnyDesign, named_design


class Controller:
    """The controller of one axis, which remembers what it has to from one sample to the next."""

    def __init__(self, design: AnyDesign, axis: str = ""):
        whole = named_design(design)
        self._whole = design = whole.by_axis().get(axis, whole)
        kind = design.kind
        self.design = design.controller
        law = needed(
            kind.law, design, "it commands a whole machine: name an axis, or take runtime.Machine"
        )
        self._law: AxisLaw = law(self.design, design.limits.of(axis or design.axis).command)
        self._sample = partial(self._law.sample, SCALARS, self._law, kind.gains(self.design))
        self._memory = self._law.initial_memory(0.0)

    def step(self, signals: Signals) -> float:
        """The command for this sample's ``signals``.

        A C-axis takes volts for error [rad], error_rate [rad/s], ...; a feed drive takes units of
        its converter for error [BLU] and, with low-velocity compensation, velocity [BLU/s].

        Raises:
            KeyError: a signal that the design reads is missing.
        """
        return self.told(signals)[0]

    def told(self, signals: Signals) -> tuple[float, Any]:
        """Step: the command, and what it is made of; None where the kind does not tell.

        Raises:
            KeyError: a signal that the design reads is missing.
        """
        command, self._memory, parts = self._sample(self._memory, signals)
        return float(limited(SCALARS, self._law.limit, command)), parts

    def remember(self, readings: dict[str, float]) -> None:
        """Take ``readings`` for those of the sample before; the rest of the memory stays."""
        told = needed(self._whole.kind.explain, self._whole, "it cannot be told what was before")
        self._memory = told.remember(self._memory, readings)

    def reset(self) -> None:
        """Forget the past, as before the first sample."""
        self._memory = self._law.initial_memory(0.0)

    def adapted(self) -> ControllerRecord:
        """The controller's record with what it has learnt by now.

        Raises:
            ValueError: it is of a kind that does not adapt.
        """
        if self._whole.kind.adapted is None:
            raise ValueError(f"a controller of kind {self.design.kind} does not adapt")
        return self._whole.kind.adapted(self.design, self._memory)


class Machine:
    """The controllers of every axis of a machine, for kinds that see all of it too."""

    def __init__(self, design: AnyDesign, axes: tuple[str, ...] = ()):
        design = named_design(design)
        self.axes = axes or tuple(design.plant.axes) or ("axis",)
        kind, limits = design.kind, design.limits.commands(self.axes)
        self._controller = kind.controller_of(design.controller, limits)
        self._gains = kind.gains(design.controller)
        self._memory = self._controller.initial_memory(0.0)

    def step(
        self, signals: Mapping[str, Signals], path: PathView | None = None, told: Parameters = None
    ) -> dict[str, float]:
        """The command of every axis by its name, for what each axis tells at this sample.

        Raises:
            KeyError: an axis, or a signal that the design reads, is missing.
        """
        view = View(tuple(signals[axis] for axis in self.axes), path, told)
        found, self._memory = self._controller.step(SCALARS, self._gains, self._memory, view)
        return dict(zip(self.axes, map(float, found), strict=True))

    def reset(self) -> None:
        """Forget the past, as before the first sample."""
        self._memory = self._controller.initial_memory(0.0)


def load(path: str | Path) -> Controller:
    """The controller of a design file, of a run folder or of a built-in design.

    Raises:
        UserError: there is no such design, or it is not one that can run.
    """
    return Controller(path)
