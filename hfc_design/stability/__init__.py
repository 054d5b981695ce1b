"""Gains that keep a sampled feed drive stable, and the gains of a rule table."""
