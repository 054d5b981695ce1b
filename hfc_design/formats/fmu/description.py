"""Description of an FMU: ``modelDescription.xml`` of FMI 2.0 and 3.0."""

import re
from collections.abc import Sequence
from math import inf, pi
from sys import float_info
from typing import NamedTuple, TypeAlias

from hfc_design import __version__
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.formats.writing import rendered


class Variable(NamedTuple):
    """Number that an importer sees; its value reference is its index among all variables."""

    name: str
    causality: str  # "independent", "input", "output", "parameter"
    unit: str
    what: str  # description
    start: float = 0.0
    discrete: bool = False  # an output that is held from one sample to the next
    fixed: bool = False  # a parameter that is read only before the first step
    lowest: float = -inf  # of a parameter
    highest: float = inf

    @property
    def variability(self) -> str:
        """Variability, in the terms of FMI."""
        if self.causality == "parameter":
            return "fixed" if self.fixed else "tunable"
        return "discrete" if self.discrete else "continuous"

    @property
    def bounds(self) -> dict[str, float]:
        """Finite bounds by their FMI names; ``LEAST`` is written as 0."""
        each = {"min": self.lowest, "max": self.highest}.items()
        return {key: 0.0 if abs(x) == LEAST else x for key, x in each if abs(x) < inf}


#: Lower bound that means "greater than zero": the smallest normal number.
LEAST = float_info.min
#: Variables that every FMU begins with, as version 3 requires.
TIME = Variable("time", "independent", "s", "time of the simulation")


class Model(NamedTuple):
    """Model that an FMU computes."""

    part: str  # "controller", "plant" or "loop" of both
    name: str  # an identifier
    what: str  # description
    every: float  # sample time [s]
    variables: list[Variable]  # the first is the time
    sources: dict[str, str]  # file name -> C code of controller and plant
    body: str  # template of ``model_begin`` and ``model_step``
    values: Json  # values for this template

    def of(self, causality: str) -> list[str]:
        """Return the names of the variables with a causality."""
        return [x.name for x in self.variables if x.causality == causality]


def described(
    model: Model, design: Design, compiled: Sequence[str], version: str, token: str
) -> str:
    """Return ``modelDescription.xml`` for "fmi2" or "fmi3"; ``compiled`` are the C files."""
    units = dict.fromkeys(x.unit for x in model.variables if x.unit)
    return rendered(
        "fmu/description.xml.j2",
        design,
        model=model,
        compiled=compiled,
        version=version,
        token=token,
        made_by=__version__,
        units={unit: base_unit(unit) for unit in units},
        # whether all members of all states are known, so that a serialised state can be checked
        known=None not in [x["saved"] for x in model.values["controllers"]],
    )


#: Base unit of FMI -> its exponent.
Exponents: TypeAlias = dict[str, int]


class BaseUnit(NamedTuple):
    """Unit as ``factor`` times the product of base units."""

    factor: float
    exponents: Exponents

    def times(self, other: "BaseUnit", power: int = 1) -> "BaseUnit":
        """Return the product of this unit and a ``power`` of another one."""
        both = {key: self.exponents.get(key, 0) for key in (*self.exponents, *other.exponents)}
        for key, exponent in other.exponents.items():
            both[key] += power * exponent
        exponents = {key: exponent for key, exponent in both.items() if exponent}
        return BaseUnit(self.factor * other.factor**power, exponents)


def _derived(factor: float = 1.0, **exponents: int) -> BaseUnit:
    return BaseUnit(factor, exponents)


#: Symbol -> base units; it lacks BLU, counts and steps of a converter, which are no SI units.
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
    """Return ``unit`` in base units; None if it contains symbols that are not in ``SYMBOLS``.

    A space multiplies, "/" divides by the following symbol or bracket, "m2" is a square.
    """
    tokens, at = [], 0
    while at < len(unit.rstrip()):
        match = TOKEN.match(unit, at)
        if match is None:
            return None
        tokens.append(match)
        at = match.end()
    return _product(tokens[::-1]) if tokens else None


def _product(left: list[re.Match[str]]) -> BaseUnit | None:
    """Remove tokens from the end of ``left`` up to a closing bracket, and return their product."""
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
