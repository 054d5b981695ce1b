"""Design hierarchical fuzzy controllers for machine-tool drives by simulation."""

__version__ = "0.1.0"
