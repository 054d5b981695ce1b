"""The proportional-integral-derivative controller of a feed drive."""
