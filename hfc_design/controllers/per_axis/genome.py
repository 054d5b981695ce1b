"""Genome of a controller of its own for every axis: that of each, side by side."""

import numpy as np

from hfc_design.controllers.beside import BesideGenome, SideBySide
from hfc_design.controllers.kind import Target, kinds
from hfc_design.controllers.per_axis import PerAxisSettings
from hfc_design.core.numbers import Json


class PerAxisGenome(BesideGenome):
    """Its parts are the axes.

    Raises:
        UserError: the axes have too many structures together.
    """

    def __init__(self, settings: PerAxisSettings, target: Target):
        own = enumerate(settings.axes.values())
        axes = [kinds().get(one.kind).genome(one, target.of(k)) for k, one in own]
        super().__init__(settings, target, axes, "axes")

    def notation(self, structure: int) -> str:
        """The structure of each axis."""
        trees = map(int, np.unravel_index(structure, self.counts))
        each = zip(self.settings.axes, self.each("notation", trees), strict=True)
        return ", ".join(f"{axis}: {own}" for axis, own in each)

    def record(self, individual: SideBySide) -> Json:
        """The record of each axis."""
        each = zip(self.settings.axes, self.each("record", individual.parts), strict=True)
        return {"kind": "per-axis", "axes": dict(each)}
