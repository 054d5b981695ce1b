"""Units as drives write them, ``"N m s/rad"``, in the base units of FMI."""

import re
from math import pi
from typing import NamedTuple, TypeAlias

#: Base unit of FMI -> its exponent.
Exponents: TypeAlias = dict[str, int]


class BaseUnit(NamedTuple):
    """A unit is ``factor`` times the product of base units."""

    factor: float
    exponents: Exponents

    def times(self, other: "BaseUnit", power: int = 1) -> "BaseUnit":
        """The product with a power of another one."""
        both = {key: self.exponents.get(key, 0) for key in (*self.exponents, *other.exponents)}
        for key, exponent in other.exponents.items():
            both[key] += power * exponent
        kept = {key: exponent for key, exponent in both.items() if exponent}
        return BaseUnit(self.factor * other.factor**power, kept)


def _derived(factor: float = 1.0, **exponents: int) -> BaseUnit:
    return BaseUnit(factor, exponents)


#: Symbol -> what it is; BLU, counts and units of a converter are none of the SI.
SYMBOLS = {
    "1": _derived(),
    "m": _derived(m=1),
    "mm": _derived(1e-3, m=1),
    "um": _derived(1e-6, m=1),
    "kg": _derived(kg=1),
    "s": _derived(s=1),
    "ms": _derived(1e-3, s=1),
    "A": _derived(A=1),
    "rad": _derived(rad=1),
    "deg": _derived(pi / 180.0, rad=1),
    "rev": _derived(2.0 * pi, rad=1),
    "Hz": _derived(s=-1),
    "N": _derived(kg=1, m=1, s=-2),
    "W": _derived(kg=1, m=2, s=-3),
    "V": _derived(kg=1, m=2, s=-3, A=-1),
    "ohm": _derived(kg=1, m=2, s=-3, A=-2),
    "Wb": _derived(kg=1, m=2, s=-2, A=-1),
    "H": _derived(kg=1, m=2, s=-2, A=-2),
}
TOKEN = re.compile(r"\s*(?:(?P<symbol>1|[A-Za-z]+)(?P<power>\d?)|\^(?P<raised>\d)|(?P<sign>[()/]))")


def base_unit(unit: str) -> BaseUnit | None:
    """What ``unit`` is; None where it has symbols of its own.

    A space multiplies, "/" divides by the symbol or the bracket behind it, "m2" is a square.
    """
    tokens, at = [], 0
    while at < len(unit.rstrip()):
        found = TOKEN.match(unit, at)
        if found is None:
            return None
        tokens.append(found)
        at = found.end()
    return _product(tokens[::-1]) if tokens else None


def _product(left: list[re.Match[str]]) -> BaseUnit | None:
    """Of the tokens up to the end or a closing bracket, which are taken off the end of ``left``."""
    whole, power = SYMBOLS["1"], 1
    while left and (token := left.pop())["sign"] != ")":
        if token["sign"] == "/":
            power = -1
            continue
        part = _product(left) if token["sign"] == "(" else SYMBOLS.get(token["symbol"] or "")
        if part is None:
            return None
        raised = int(left.pop()["raised"]) if left and left[-1]["raised"] else 1
        whole = whole.times(part, power * raised * int(token["power"] or 1))
        power = 1
    return whole
