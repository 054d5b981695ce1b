"""The fuzzy controller that adapts within a stable range (Jee & Koren 2004)."""
