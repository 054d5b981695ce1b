"""A run and its folder: the search problem of a scenario, the run, and its stored results."""
