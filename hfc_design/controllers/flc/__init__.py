"""Two-input fuzzy controller of a feed drive (Jee & Koren 1995, 2004)."""

from hfc_design.controllers.flc.record import FlcDesign as KIND

__all__ = ["KIND"]
