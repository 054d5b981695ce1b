"""Paths in X-Y: their shapes, the motion along them, where they come from, how far off one is."""
