"""Kinds of controller, a folder each, and the code that they share."""
