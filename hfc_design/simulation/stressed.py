"""What is told of a stress: does the design hold, and at what size does it break? No JAX."""

from collections.abc import Iterable
from math import isfinite
from typing import NamedTuple

from hfc_design.core.numbers import Json

#: How an answer begins, the best first.
YES, ON_THIS_MODEL, NO = "yes", "on this model only", "no"


class Stressed(NamedTuple):
    """One stress on some machines, in all motions."""

    name: str  # in words, with its whole size
    holds: bool
    share: float  # of the machines that hold without it
    merit: float  # of the median machine, times that without it; 0: it fails
    #: Where it breaks: the least size that was tried and does, as a share of the whole and in
    #: words, and what happens then. Nothing of one that holds.
    part: float = 1.0
    breaks: str = ""
    why: str = ""

    def numbers(self) -> Json:
        """As plain data."""
        return self._asdict() | {"merit": self.merit if isfinite(self.merit) else None}


def breaking(each: Iterable[Stressed]) -> str:
    """What breaks a design at the smallest part of its size, how many others do; "": nothing."""
    broken = sorted((one for one in each if not one.holds), key=lambda one: one.part)
    if not broken:
        return ""
    first, more = broken[0], len(broken) - 1
    others = f", and {more} more stress{'es break' if more > 1 else ' breaks'} it" if more else ""
    return f"with {first.breaks} it {first.why}{others}"


#: Heads of ``rows``.
HEADS = ("stress", "holds on [%]", "merit [times]")
ABOUT = (
    "stress: one at a time on machines that hold without it, in all motions required of them; "
    "merit: of the median machine, times that without it"
)


def rows(found: Iterable[Json]) -> list[list[str]]:
    """A row for each stress, as tables have it."""
    return [
        [
            one["name"],
            f"{100 * one['share']:.3g}",
            f"{one['merit'] or 0.0:.2f}" if one["holds"] else "breaks",
        ]
        for one in found
    ]


def broken(found: Iterable[Json]) -> list[str]:
    """A line for each stress that breaks the design, the first first."""
    each = sorted((one for one in found if not one["holds"]), key=lambda one: float(one["part"]))
    return [f"breaks: with {one['breaks']} it {one['why']}" for one in each]
