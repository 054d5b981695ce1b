"""Checks of arguments from scripts: a mistake is reported in a line, like one in a file."""

from math import isfinite
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from typing import Any

from hfc_design.core.records import UserError, option


def check_type(thing: Any, kinds: type | tuple[type, ...], what: str) -> None:
    """Check the class of an argument; UserError: it is not ``what`` (a text for the message)."""
    if not isinstance(thing, kinds):
        raise UserError(f"argument must be {what} (got {a_kind(thing)})")


def path_of(place: Any) -> Path:
    """Return an argument of a script as a path; UserError: it is not a path."""
    check_type(place, (str, PathLike), "the path of a file or folder")
    return Path(place)


def check_whole(name: str, given: Any, low: int, high: int | None = None) -> None:
    """Check for a whole number from ``low`` to ``high``; UserError: it is another value.

    ``name`` is the name of the argument. True and False are not accepted as numbers.
    """
    if isinstance(given, bool) or not isinstance(given, Integral):
        raise UserError(f"{option(name, given)}: must be a whole number")
    if high is not None and not low <= int(given) <= high:
        raise UserError(f"{option(name, given)}: must be between {low} and {high}")
    if int(given) < low:
        raise UserError(f"{option(name, given)}: must be at least {low}")


def check_number(name: str, given: Any, **names: str) -> None:
    """Check for a finite number; UserError: it is another value. For ``names`` see ``option``."""
    if isinstance(given, bool) or not isinstance(given, Real):
        raise UserError(f"{option(name, given, **names)}: must be a number")
    if not isfinite(float(given)):
        raise UserError(f"{option(name, given, **names)}: must be a finite number")


def check_positive(name: str, given: Any, **names: str) -> None:
    """Check for a number greater than 0; UserError: it is another value."""
    check_number(name, given, **names)
    if given <= 0:
        raise UserError(f"{option(name, given, **names)}: must be greater than 0")


def check_share(name: str, given: Any, **names: str) -> None:
    """Check for a share between 0 and 1, excluding both; UserError: it is another value."""
    check_number(name, given, **names)
    if not 0 < given < 1:
        fault = "must be between 0 and 1, as in 0.2 for +-20 %"
        raise UserError(f"{option(name, given, **names)}: {fault}")


def a_kind(thing: Any) -> str:
    """Return the class of a value in words: ``a Design``, ``an int``."""
    name = type(thing).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
