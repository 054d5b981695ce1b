"""Figures of designs, of searches and of paths; none touches pyplot."""
