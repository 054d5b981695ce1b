"""The genome of a hierarchy without a scenario."""

from hfc_design.controllers.hierarchical.genome import HierarchicalGenome
from hfc_design.controllers.hierarchical.record import HierarchicalSettings
from hfc_design.controllers.kind import Target


def searched_of(names, search=None):
    """Of inputs with these names and the scale 10, within the bounds of a search."""
    inputs = [{"name": name, "scale": 10.0} for name in names]
    return HierarchicalGenome(
        HierarchicalSettings(inputs=inputs), Target(None, (), 0.001, {}, search)
    )
