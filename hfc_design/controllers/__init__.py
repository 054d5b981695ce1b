"""Kinds of controller: a folder each, and what they have in common."""
