"""Simulation of the closed loop: of one machine, of populations, of a design on a scenario."""
