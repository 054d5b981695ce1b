"""Description of an FMU: ``modelDescription.xml`` of FMI 2.0 and 3.0."""

import re
from collections.abc import Sequence
from math import inf
from sys import float_info
from typing import NamedTuple

from hfc_design import __version__
from hfc_design.core.numbers import Json
from hfc_design.core.quantities import registry
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
    variables: list[Variable]  # the first is the time
    sources: dict[str, str]  # file name -> C code of controller and plant
    values: Json  # for the templates of ``model_begin`` and ``model_step``

    def of(self, causality: str) -> list[str]:
        """Return the names of the variables with a causality."""
        return [x.name for x in self.variables if x.causality == causality]


def described(
    model: Model, design: Design, compiled: Sequence[str], version: str, token: str
) -> str:
    """Return ``modelDescription.xml`` for "fmi2" or "fmi3"; ``compiled`` are the C files."""
    units = dict.fromkeys(x.unit for x in model.variables if x.unit)
    values: Json = {"model": model, "compiled": compiled, "version": version, "token": token}
    values |= {"made_by": __version__, "units": {unit: base_unit(unit) for unit in units}}
    # Whether all members of all states are known, so that a serialised state can be checked.
    values["known"] = None not in [x["saved"] for x in model.values["controllers"]]
    return rendered("fmu/description.xml.j2", design, **values)


#: Name of a base unit in pint -> in FMI; none of BLU, counts and steps of a converter is SI.
BASES = {"kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "radian": "rad"}
#: A text that may be a unit; the digits of its powers.
UNIT, POWER = re.compile(r"[\w /()^]+"), re.compile(r"(?<=[A-Za-z])(?=[0-9])")


class BaseUnit(NamedTuple):
    """Unit as ``factor`` times the product of base units."""

    factor: float
    exponents: dict[str, int]  # base unit of FMI -> its exponent


def base_unit(unit: str) -> BaseUnit | None:
    """Return ``unit``, such as "N m2/(rad/s)", in base units; None if it is not made of these."""
    if not UNIT.fullmatch(unit):
        return None
    try:
        quantity = (1.0 * registry().parse_units(POWER.sub("**", unit))).to_base_units()
    except Exception:  # of pint and of Python's parser
        return None
    powers = {BASES.get(name, ""): int(power) for name, power in quantity.unit_items()}
    return None if "" in powers else BaseUnit(float(quantity.magnitude), powers)
