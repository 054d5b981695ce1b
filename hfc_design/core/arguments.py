"""Checks of arguments from scripts: a mistake is reported in a line, like one in a file."""

from math import isfinite
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from typing import Any

from hfc_design.core.records import UserError


def check_type(thing: Any, kinds: type | tuple[type, ...], what: str) -> None:
    """Check that ``thing`` is of one of the ``kinds``; UserError: it is not a ``what``."""
    if not isinstance(thing, kinds):
        raise UserError(f"argument must be {what} (got {a_kind(thing)})")


def path_of(place: Any) -> Path:
    """Path from an argument of a script; UserError: it is not a path."""
    check_type(place, (str, PathLike), "the path of a file or folder")
    return Path(place)


def check_whole(option: str, given: Any, low: int, high: int | None = None) -> None:
    """Check for a whole number from ``low`` to ``high``; UserError: it is another value.

    ``option`` is its name on the command line, as in --samples, or --tolerance mass= for one of
    several. True is not accepted as a number.
    """
    if isinstance(given, bool) or not isinstance(given, Integral):
        raise _refused(option, repr(given), "must be a whole number")
    if high is not None and not low <= int(given) <= high:
        raise _refused(option, given, f"must be between {low} and {high}")
    if int(given) < low:
        raise _refused(option, given, f"must be at least {low}")


def check_number(option: str, given: Any) -> None:
    """Check for a finite number; UserError: it is another value."""
    if isinstance(given, bool) or not isinstance(given, Real):
        raise _refused(option, repr(given), "must be a number")
    if not isfinite(float(given)):
        raise _refused(option, given, "must be a finite number")


def check_positive(option: str, given: Any) -> None:
    """Check for a number greater than 0; UserError: it is another value."""
    check_number(option, given)
    if given <= 0:
        raise _refused(option, given, "must be greater than 0")


def check_share(option: str, given: Any) -> None:
    """Check for a share between 0 and 1, excluding both; UserError: it is another value."""
    check_number(option, given)
    if not 0 < given < 1:
        raise _refused(option, given, "must be between 0 and 1, as in 0.2 for +-20 %")


def _refused(option: str, given: Any, rule: str) -> UserError:
    return UserError(f"{option}{'' if option.endswith('=') else ' '}{given}: {rule}")


def a_kind(thing: Any) -> str:
    """Type of a value, in words: ``a Design``, ``an int``."""
    name = type(thing).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
