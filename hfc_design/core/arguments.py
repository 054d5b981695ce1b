"""What a script gives to the functions of the API: a mistake is a line, as one in a file is."""

from os import PathLike
from pathlib import Path
from typing import Any

from hfc_design.core.records import UserError


def wanted(thing: Any, kinds: type | tuple[type, ...], what: str) -> None:
    """Whether ``thing`` is of one of the ``kinds``; UserError: it is none, said as ``what``."""
    if not isinstance(thing, kinds):
        raise UserError(f"{a_kind(thing)} is no {what}")


def path_of(place: Any) -> Path:
    """A path that a script names; UserError: it is none."""
    wanted(place, (str, PathLike), "path of a file or folder")
    return Path(place)


def a_kind(thing: Any) -> str:
    """``a Design``, ``an int``: what somebody gave."""
    name = type(thing).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
