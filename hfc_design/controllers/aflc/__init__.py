"""Fuzzy controller that adapts within a stable range (Jee & Koren 2004)."""

from hfc_design.controllers.aflc.record import AflcDesign as KIND

__all__ = ["KIND"]
