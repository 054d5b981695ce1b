"""A run and its folder: what a search needs of a scenario, the run itself, batches of runs."""
