"""What a script gives to ``step``: whether it is finite, and what is wrong with it.

The latter is looked for only when a step has failed.
"""

from collections.abc import Callable, Iterable
from math import isfinite
from numbers import Real
from typing import Any

from hfc_design.controllers.controller import Signals
from hfc_design.controllers.kind import ControllerRecord, Kind
from hfc_design.core.arguments import a_kind
from hfc_design.core.faults import short
from hfc_design.core.numbers import finite
from hfc_design.core.records import UserError


class Missing(UserError, KeyError):
    """A signal or an axis is missing; a KeyError, as the mapping of a script raises it."""


def told(given: Iterable[Any], error: Exception, what: str = "signal") -> Exception:
    """The line for a step that failed with ``error``; that itself where nothing is wrong here.

    ``given`` are mappings of names to readings, or to what an axis has where ``what`` is "axis".
    """
    for one in given:
        if not isinstance(one, dict) and not hasattr(one, "keys"):
            return UserError(f"{a_kind(one)} is no mapping of names to readings")
        if isinstance(error, KeyError) and error.args[0] not in one:
            return Missing(f"the {what} {error} is missing; given are {', '.join(one) or 'none'}")
        for name, x in one.items():
            if what == "signal" and not isinstance(x, Real):
                return UserError(f"{name} = {short(x)}: has to be a number")
    return error


def reader(kind: Kind, record: ControllerRecord) -> Callable[[Signals], bool]:
    """Whether what the law of a ``record`` reads is finite; every signal where that is not told."""
    if not (names := kind.reads(record) if kind.reads else []):
        return finite

    def reads(signals: Signals) -> bool:
        try:
            return all(map(isfinite, map(signals.__getitem__, names)))
        except KeyError:  # the law tells which is missing, if it does read it
            return finite(signals)

    return reads
