"""Builds the reference from the code: every key, parameter and part, with its meaning."""
