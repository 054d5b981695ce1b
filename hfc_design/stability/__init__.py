"""Stability: margins of loops, stable gains of a sampled feed drive, gains of a rule table."""
