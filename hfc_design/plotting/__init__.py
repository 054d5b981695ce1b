"""Figures of designs, of searches and of paths; none uses pyplot."""
