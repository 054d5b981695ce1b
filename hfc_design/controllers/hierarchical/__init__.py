"""PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)."""
