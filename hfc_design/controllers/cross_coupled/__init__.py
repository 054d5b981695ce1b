"""Axis controllers of any kind with a common controller of the contour error (Koren 1980)."""

from collections import namedtuple

import numpy as np

from hfc_design.controllers.beside import AroundGenome, SideBySide
from hfc_design.controllers.cross_coupled.law import CrossGains
from hfc_design.controllers.cross_coupled.record import CrossCoupledDesign, CrossCoupledSettings
from hfc_design.controllers.gains.genome import GainsGenome
from hfc_design.controllers.kind import Kind, Target, later
from hfc_design.controllers.per_axis import INSIDE, OuterDesign
from hfc_design.core.numbers import Json


def _reads(record: CrossCoupledDesign) -> list[str]:
    own = ["error", *(["reference_rate"] if record.feed_forward else [])]
    return list(dict.fromkeys([*own, *record.inner_reads()]))


class _OwnGenome(GainsGenome):
    """Of the gains on the contour error, and of one on the velocity of each axis."""

    def __init__(self, settings: CrossCoupledSettings, target: Target):
        super().__init__(settings, target)
        found = settings.searched()._asdict()
        velocity = found.pop("velocity")
        found |= {f"velocity_{axis}": velocity for axis in target.machine.axes}
        self.ranges = namedtuple("Ranges", found)(**found)


class CrossCoupledGenome(AroundGenome):
    """Its parts are what is inside, and its own gains."""

    def __init__(self, settings: CrossCoupledSettings, target: Target):
        super().__init__(settings, target, _OwnGenome(settings, target))

    def gains(self, population: SideBySide) -> CrossGains:
        """As the simulator wants them."""
        inner, own = self.each("gains", population.parts)
        k_p, k_i, k_d, *velocity = own
        return CrossGains(inner, k_p, k_i, k_d, tuple(np.stack(velocity)))

    def record(self, individual: SideBySide) -> Json:
        """The record of what is inside, and the gains."""
        inner, own = self.parts
        found = own.gains(individual.parts[1])
        k_p, k_i, k_d, *velocity = (float(gain[0]) for gain in found)
        return {
            "kind": self.settings.kind,
            "inner": inner.record(individual.parts[0]),
            "contour": {"k_p": k_p, "k_i": k_i, "k_d": k_d},
            "feed_forward": dict(zip(self.target.machine.axes, velocity, strict=True)),
        }


KIND = Kind(
    name="cross-coupled",
    no_rules="rule tables are but inside it, in its axes' controllers; c and fmu hold all of it",
    summary="a PID on the contour error beside axis controllers of any kind (Koren 1980)",
    record=CrossCoupledDesign,
    settings=CrossCoupledSettings,
    gains=CrossCoupledDesign.gains,
    controller=CrossCoupledDesign.controller,
    genome=CrossCoupledGenome,
    learnt=lambda record, axes, memory: record.learnt(axes, memory.inner),
    inside=INSIDE,
    structure=OuterDesign.structure,
    path=True,
    reads=_reads,
    reach=CrossCoupledDesign.reach,
    sections=later("hfc_design.controllers.cross_coupled.section", "sections"),
)
