"""What an FMU says of itself: ``modelDescription.xml`` of FMI 2.0 and 3.0, and how it is built."""

import re
from collections.abc import Mapping, Sequence
from math import inf, pi
from sys import float_info
from typing import NamedTuple, TypeAlias
from xml.etree import ElementTree

from hfc_design import __version__
from hfc_design.core.numbers import Json


class Variable(NamedTuple):
    """A number that an importer sees; its value reference is its place among all."""

    name: str
    causality: str  # "independent", "input", "output", "parameter"
    unit: str
    what: str
    start: float = 0.0
    discrete: bool = False  # an output that is held from one sample to the next
    fixed: bool = False  # a parameter that is of use before the first step only
    lowest: float = -inf  # of a parameter
    highest: float = inf

    @property
    def variability(self) -> str:
        """As FMI calls it."""
        if self.causality == "parameter":
            return "fixed" if self.fixed else "tunable"
        return "discrete" if self.discrete else "continuous"


#: The smallest number that is more than zero.
LEAST = float_info.min
#: What every FMU begins with, as version 3 asks.
TIME = Variable("time", "independent", "s", "time of the simulation")
LOG_CATEGORIES = ("logStatusWarning", "logStatusError")


class Model(NamedTuple):
    """What an FMU computes."""

    part: str  # "controller", "plant" or "loop" of both
    name: str  # an identifier
    what: str
    every: float  # sample time [s]
    variables: list[Variable]  # the first is the time
    sources: dict[str, str]  # C of what is inside, by file
    body: str  # template of ``model_begin`` and ``model_step``
    values: Json  # what that reads

    def of(self, causality: str) -> list[str]:
        """Names of the variables of a causality."""
        return [x.name for x in self.variables if x.causality == causality]


class Description(NamedTuple):
    """Writes what an FMU says of itself."""

    model: Model
    compiled: Sequence[str]  # files to compile

    def fmi2(self, token: str) -> str:
        """``modelDescription.xml`` of FMI 2.0."""
        root = self._root("2.0", guid=token)
        told = self._told(canGetAndSetFMUstate="true", canSerializeFMUstate=self._known())
        files = _sub(_sub(root, "CoSimulation", told), "SourceFiles")
        for name in self.compiled:
            _sub(files, "File", {"name": name})
        self._between(root)
        listed = _sub(root, "ModelVariables")
        for k, variable in enumerate(self.model.variables):
            found = _sub(listed, "ScalarVariable", _attributes(k, variable))
            _sub(found, "Real", _value(variable))
        structure = _sub(root, "ModelStructure")
        for name in ("Outputs", "InitialUnknowns"):
            unknown = _sub(structure, name)
            for k in self._outputs():
                _sub(unknown, "Unknown", {"index": str(k + 1)})
        return _text(root)

    def fmi3(self, token: str) -> str:
        """``modelDescription.xml`` of FMI 3.0."""
        root = self._root("3.0", instantiationToken=token)
        told = self._told(canGetAndSetFMUState="true", canSerializeFMUState=self._known())
        _sub(root, "CoSimulation", told | {"fixedInternalStepSize": repr(self.model.every)})
        self._between(root)
        listed = _sub(root, "ModelVariables")
        for k, variable in enumerate(self.model.variables):
            _sub(listed, "Float64", _attributes(k, variable) | _value(variable))
        structure = _sub(root, "ModelStructure")
        for name in ("Output", "InitialUnknown"):
            for k in self._outputs():
                _sub(structure, name, {"valueReference": str(k)})
        return _text(root)

    def build(self) -> str:
        """``sources/buildDescription.xml`` of FMI 3.0."""
        root = ElementTree.Element("fmiBuildDescription", fmiVersion="3.0")
        build = _sub(root, "BuildConfiguration", {"modelIdentifier": self.model.name})
        files = _sub(build, "SourceFileSet", {"language": "C99"})
        for name in self.compiled:
            _sub(files, "SourceFile", {"name": name})
        return _text(root)

    def _root(self, version: str, **token: str) -> ElementTree.Element:
        told = {
            "fmiVersion": version,
            "modelName": self.model.name,
            **token,
            "description": self.model.what,
        }
        told["generationTool"] = f"hfc-design {__version__}"
        return ElementTree.Element(
            "fmiModelDescription", told | {"variableNamingConvention": "structured"}
        )

    def _told(self, **others: str) -> dict[str, str]:
        """Attributes of the co-simulation."""
        step = {"canHandleVariableCommunicationStepSize": "false"}
        return {"modelIdentifier": self.model.name, **step, **others}

    def _known(self) -> str:
        """Whether it is known what every state is, so that bytes of it can be checked."""
        states = [x["saved"] for x in self.model.values["controllers"]]
        return "false" if None in states else "true"

    def _between(self, root: ElementTree.Element) -> None:
        """What both versions have before the variables."""
        units = _sub(root, "UnitDefinitions")
        for unit in dict.fromkeys(x.unit for x in self.model.variables if x.unit):
            own, base = _sub(units, "Unit", {"name": unit}), base_unit(unit)
            if base is not None:
                factor = {} if base.factor == 1.0 else {"factor": repr(base.factor)}
                exponents = {key: str(value) for key, value in base.exponents.items()}
                _sub(own, "BaseUnit", exponents | factor)
        categories = _sub(root, "LogCategories")
        for name in LOG_CATEGORIES:
            _sub(categories, "Category", {"name": name})
        _sub(root, "DefaultExperiment", {"startTime": "0.0", "stepSize": repr(self.model.every)})

    def _outputs(self) -> list[int]:
        """Value references of the outputs."""
        return [k for k, x in enumerate(self.model.variables) if x.causality == "output"]


def _attributes(k: int, variable: Variable) -> dict[str, str]:
    """What both versions say of a variable but for its number."""
    told = {"name": variable.name, "valueReference": str(k), "description": variable.what}
    return told | {"causality": variable.causality, "variability": variable.variability}


def _value(variable: Variable) -> dict[str, str]:
    """What both versions say of its number."""
    found = {"unit": variable.unit} if variable.unit else {}
    for key, bound in (("min", variable.lowest), ("max", variable.highest)):
        if abs(bound) < inf:
            found[key] = repr(0.0 if abs(bound) == LEAST else bound)
    if variable.causality in ("input", "parameter"):
        found["start"] = repr(float(variable.start))
    return found


def _sub(
    parent: ElementTree.Element, name: str, attributes: Mapping[str, str] | None = None
) -> ElementTree.Element:
    return ElementTree.SubElement(parent, name, dict(attributes or {}))


def _text(root: ElementTree.Element) -> str:
    ElementTree.indent(root)
    head = '<?xml version="1.0" encoding="UTF-8"?>\n'
    return head + ElementTree.tostring(root, encoding="unicode") + "\n"


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
