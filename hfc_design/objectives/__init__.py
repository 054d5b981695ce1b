"""Objectives, metrics and constraints: what makes a closed loop good."""
