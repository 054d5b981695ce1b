"""Controllers: pure step functions of scalars, one file a kind."""

from typing import Any

import numpy as np

from hfc_design.controllers.controller import Controller
from hfc_design.controllers.hierarchical import HierarchicalGains, Layout, hierarchical
from hfc_design.controllers.pd import PdGains, pd
from hfc_design.fuzzy import Term
from hfc_design.rulebase import HierarchicalDesign, PdDesign

#: The ``kind`` of a design file -> what it is, for ``hfc list controllers``.
KINDS = {
    "pd": "proportional-derivative: v = kp e + kd de/dt",
    "pd+hierarchical-fuzzy": "PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)",
}


def from_design(record: PdDesign | HierarchicalDesign) -> tuple[Controller, Any]:
    """The controller that a design file describes and its gains, as a population of one."""
    gains = PdGains(np.array([record.pd.kp]), np.array([record.pd.kd]))
    if isinstance(record, PdDesign):
        return pd(), gains
    layout = Layout(  # its scales stand in the gains, so that all designs share a program
        tuple(item.name for item in record.inputs),
        (1.0,) * len(record.inputs),
        record.output_scale,
        tuple(Term(**term.model_dump()) for term in record.terms),
    )
    return hierarchical(layout), HierarchicalGains(
        *gains,
        scales=np.array([item.scale for item in record.inputs])[:, None],
        sources=np.array(record.sources(), np.int32)[..., None],
        consequents=np.array([unit.consequents for unit in record.units])[..., None],
    )


__all__ = [
    "KINDS",
    "Controller",
    "HierarchicalGains",
    "Layout",
    "PdGains",
    "from_design",
    "hierarchical",
    "pd",
]
