"""The two-input fuzzy controller of a feed drive (Jee & Koren 1995, 2004)."""
