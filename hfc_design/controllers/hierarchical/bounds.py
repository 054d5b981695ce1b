"""Within what a search varies a hierarchy."""

from typing import Any, NamedTuple


class Bounds(NamedTuple):
    """On the C-axis; the ``[search]`` of a scenario may have other values under these keys."""

    kp_range: tuple[float, float] = (100.0, 10_000.0)  # of the first individuals [V/rad]
    kd_range: tuple[float, float] = (30.0, 3_000.0)  # [V s/rad]
    scale_range: float = 10.0  # factor around the layout's scales; 1: they stay
    inner_limit: float = 4.0  # |consequent| of an inner unit
    root_limit: float = 20.0  # |consequent| of the root


def bounds_of(search: Any) -> Bounds:
    """The bounds that the settings of a search have, else the defaults."""
    found = {key: getattr(search, key) for key in Bounds._fields if hasattr(search, key)}
    return Bounds()._replace(**found)
