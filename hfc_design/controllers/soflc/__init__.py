"""The fuzzy controller that organises itself (Jee & Koren 1995)."""
