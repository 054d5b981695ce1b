"""Quantities as texts, such as ``"20 urad"``, and their conversion to numbers in another unit."""

import math
import re
from functools import cache
from typing import Any

#: A number and a unit, but no formula, which could take long to compute.
WRITTEN = re.compile(
    r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]{1,3})?)\s*"
    r"([A-Za-zµμ°%][A-Za-z0-9µμ°%]{0,15}(?:[ */][A-Za-zµμ°%][A-Za-z0-9µμ°%]{0,15}){0,3})"
)


def known(text: float | str) -> float | str:
    """Validate a quantity; ValueError: it is a text that is not a number with a known unit."""
    if isinstance(text, str):
        _quantity(text)
    return text


def number(quantity: float | str, unit: str, millimetres: float | None = None) -> float:
    """Return a quantity as a number in ``unit``; the unit "BLU" is ``millimetres`` long.

    Raises:
        ValueError: it cannot be converted to that unit.
    """
    if not isinstance(quantity, str):
        return float(quantity)
    return float(_quantity(quantity, millimetres, unit).magnitude)


def without_unit(value: Any, unit: str) -> str:
    """Return the hint to write ``"40 kg"`` as a number in ``unit``; "" for any other value."""
    if not (isinstance(value, str) and unit):
        return ""
    try:
        return f", without the unit: {number(value, unit):.12g}"
    except ValueError:
        return ""


def _quantity(text: str, millimetres: float | None = None, unit: str | None = None) -> Any:
    """Return the quantity in ``unit`` (None: its own); ValueError: see ``number`` and ``known``."""
    import pint

    match = WRITTEN.fullmatch(text.strip())
    if not match or not math.isfinite(float(match[1])):
        raise ValueError(f"{text[:40]!r} must be a number with a unit, as in '20 urad'")
    try:
        quantity = registry(millimetres).Quantity(float(match[1]), match[2])
    except (pint.PintError, AttributeError, TypeError, ValueError):
        raise ValueError(f"{text[:40]!r}: unknown unit {match[2]}") from None
    try:
        return quantity if unit is None else quantity.to(unit)
    except (pint.PintError, AssertionError):
        raise ValueError(f"{text!r}: must have a unit that converts to {unit}") from None


@cache
def registry(millimetres: float | None = None) -> Any:
    """Return the known units; "BLU" is ``millimetres`` long."""
    import pint

    units: Any = pint.UnitRegistry(cache_folder=None)
    units.define("@alias turn = rev")
    units.define("unit = [converter]")  # step of a converter: some drives count commands in it
    units.define("BLU = [counter]" if millimetres is None else f"BLU = {millimetres!r} mm")
    return units
