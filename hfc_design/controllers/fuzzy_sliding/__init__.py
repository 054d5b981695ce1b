"""Adaptive fuzzy sliding control of an axis (Lin & Gai 2009)."""

from hfc_design.controllers.fuzzy_sliding.record import SlidingDesign as KIND

__all__ = ["KIND"]
