"""What an FMU says of itself: ``modelDescription.xml`` of FMI 2.0 and 3.0, and how it is built."""

from collections.abc import Mapping, Sequence
from math import inf
from sys import float_info
from typing import NamedTuple
from xml.etree import ElementTree

from hfc_design import __version__
from hfc_design.core.numbers import Json
from hfc_design.formats.fmu.units import base_unit


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
