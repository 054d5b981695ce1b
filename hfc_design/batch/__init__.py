"""Batches of runs from one file: planning, running here or on workers, and results."""
