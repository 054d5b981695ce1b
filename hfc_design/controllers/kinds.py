"""Controllers: pure step functions of scalars, one file a kind."""

from typing import Any

import numpy as np

from hfc_design.controllers.aflc.controller import aflc
from hfc_design.controllers.controller import Controller
from hfc_design.controllers.flc.controller import flc
from hfc_design.controllers.flc.record import AflcDesign, FeedDesign, FlcDesign, PidDesign
from hfc_design.controllers.gains.controller import of_law
from hfc_design.controllers.hierarchical.law import HierarchicalGains, Layout, hierarchical
from hfc_design.controllers.hierarchical.unit import Term
from hfc_design.controllers.pd.controller import PdGains, pd
from hfc_design.controllers.pid.controller import pid
from hfc_design.controllers.soflc.controller import soflc
from hfc_design.files.design import BuiltInDesign, HierarchicalDesign, LawDesign, PdDesign

#: The ``kind`` of a design file -> what it is, for ``hfc list controllers``.
KINDS = {
    "pd": "proportional-derivative: v = kp e + kd de/dt",
    "pd+hierarchical-fuzzy": "PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)",
    "pid": "proportional-integral-derivative on an error in BLU",
    "flc": "two-input fuzzy controller with an integral term (Jee & Koren 1995, 2004)",
    "aflc": "flc that adapts its terms and rules within a stable range (Jee & Koren 2004)",
    "soflc": "flc that organises its terms and rules itself (Jee & Koren 1995)",
}


def from_design(record: BuiltInDesign | LawDesign) -> tuple[Controller, Any]:
    """The controller that a design file describes and its gains, as a population of one."""
    if isinstance(record, LawDesign):
        return of_law(record.law, record.sample_time_s), _population_of_one(record.values())
    if not isinstance(record, PdDesign | HierarchicalDesign):
        return _feed_drive(record), _population_of_one(record.gains())
    gains = PdGains(np.array([record.pd.kp]), np.array([record.pd.kd]))
    if isinstance(record, PdDesign):
        return pd(), gains
    layout = Layout(  # its scales stand in the gains, so that all designs share a program
        tuple(item.name for item in record.inputs),
        (1.0,) * len(record.inputs),
        record.output_scale,
        tuple(Term(**term.model_dump()) for term in record.terms),
        record.adaptation.law() if record.adaptation else None,
    )
    return hierarchical(layout), HierarchicalGains(
        *gains,
        scales=np.array([item.scale for item in record.inputs])[:, None],
        sources=np.array(record.sources(), np.int32)[..., None],
        consequents=np.array([unit.consequents for unit in record.units])[..., None],
    )


def _feed_drive(record: FeedDesign) -> Controller:
    if isinstance(record, FlcDesign):
        return flc(record.form, record.sample_time_s)
    if isinstance(record, PidDesign):
        return pid(record.sample_time_s)
    return (aflc if isinstance(record, AflcDesign) else soflc)(record.sample_time_s)


def _population_of_one(gains: Any) -> Any:
    """A record of numbers and tables with an axis of individuals behind each."""
    if gains is None:
        return None
    if hasattr(gains, "_fields"):
        return type(gains)(*(_population_of_one(part) for part in gains))
    return np.array(gains)[..., None]


__all__ = [
    "KINDS",
    "Controller",
    "HierarchicalGains",
    "Layout",
    "PdGains",
    "aflc",
    "flc",
    "from_design",
    "hierarchical",
    "of_law",
    "pd",
    "pid",
    "soflc",
]
