"""Objectives, metrics and constraints: the measures of a good closed loop."""
