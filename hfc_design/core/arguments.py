"""What a script gives to the functions of the API: a mistake is a line, as one in a file is."""

from math import isfinite
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from typing import Any

from hfc_design.core.records import UserError


def check_type(thing: Any, kinds: type | tuple[type, ...], what: str) -> None:
    """Whether ``thing`` is of one of the ``kinds``; UserError: it is none, said as ``what``."""
    if not isinstance(thing, kinds):
        raise UserError(f"argument must be {what} (got {a_kind(thing)})")


def path_of(place: Any) -> Path:
    """A path that a script names; UserError: it is none."""
    check_type(place, (str, PathLike), "the the path of a file or folder")
    return Path(place)


def check_whole(option: str, given: Any, low: int, high: int | None = None) -> None:
    """Whether a whole number is given, from ``low`` to ``high``; UserError: it is none.

    ``option`` is what a command line calls it, as in --samples, or --tolerance mass= in front of
    one of several. True is no number.
    """
    if isinstance(given, bool) or not isinstance(given, Integral):
        raise _refused(option, repr(given), "must be a whole number")
    if high is not None and not low <= int(given) <= high:
        raise _refused(option, given, f"must be between {low} and {high}")
    if int(given) < low:
        raise _refused(option, given, f"must be at least {low}")


def check_number(option: str, given: Any) -> None:
    """The same of a finite number."""
    if isinstance(given, bool) or not isinstance(given, Real):
        raise _refused(option, repr(given), "must be a number")
    if not isfinite(float(given)):
        raise _refused(option, given, "must be a finite number")


def check_positive(option: str, given: Any) -> None:
    """The same of a number greater than 0."""
    check_number(option, given)
    if given <= 0:
        raise _refused(option, given, "must be greater than 0")


def check_share(option: str, given: Any) -> None:
    """The same of a share between 0 and 1, neither of them."""
    check_number(option, given)
    if not 0 < given < 1:
        raise _refused(option, given, "must be between 0 and 1, as in 0.2 for +-20 %")


def _refused(option: str, given: Any, rule: str) -> UserError:
    return UserError(f"{option}{'' if option.endswith('=') else ' '}{given}: {rule}")


def a_kind(thing: Any) -> str:
    """``a Design``, ``an int``: what somebody gave."""
    name = type(thing).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
