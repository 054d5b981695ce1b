"""PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)."""

from hfc_design.controllers.hierarchical.record import HierarchicalDesign as KIND

__all__ = ["KIND"]
