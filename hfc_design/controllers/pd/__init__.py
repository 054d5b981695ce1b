"""The proportional-derivative controller."""
