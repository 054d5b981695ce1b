"""Walks the code and makes the reference of it: every key, parameter and part, with its meaning."""
