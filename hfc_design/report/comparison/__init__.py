"""Designs side by side as a page, tables and pictures."""
