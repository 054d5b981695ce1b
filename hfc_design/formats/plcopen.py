"""A project of PLCopen's XML (TC6 2.01): the block of ``--to st``, and a task that calls it."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from typing import TypeAlias

from hfc_design import __version__
from hfc_design.core.numbers import Json
from hfc_design.core.records import harmless
from hfc_design.files.design import Design
from hfc_design.formats.code import CLASH, block_values, c_name
from hfc_design.formats.fcl import real
from hfc_design.formats.flash.folder import page_of_axes
from hfc_design.formats.st import with_vectors
from hfc_design.formats.writing import (
    Content,
    Format,
    check_names,
    facts,
    rendered,
    signal_meanings,
    signal_units,
)

SPACES = {
    "xmlns": "http://www.plcopen.org/xml/tc6_0201",
    "xmlns:xhtml": "http://www.w3.org/1999/xhtml",
}
#: The schema wants one; the same design gives the same bytes.
CREATED = "1970-01-01T00:00:00"
CALL = (
    "Call it once a sample; with reset TRUE it first forgets the past. Where an input is infinite "
    "or no number, or the command would be, fault is TRUE and the command 0, and the next sample "
    "goes on as if this one had not been."
)
EXAMPLE = (
    "An example: give the variables what the drive's sensors tell, in the units that they name, "
    "and the drive the command; fault belongs to what stops the machine."
)
#: Name, type or that of a derived block, first value or values, what it is.
Variable: TypeAlias = "tuple[str, str, float | Sequence[float] | None, str]"


def project(design: Design) -> str:
    """``design`` as a project of one function block and a program that a task calls.

    Raises:
        UserError: the kind has no Structured Text, or a name is none of the language.
    """
    template, values = block_values(design)
    name: str = values["block"]
    program, instance = f"{name}_example", f"{name}_1"
    check_names("st", [name, program, instance, *values["signals"], "command", "fault"], CLASH)
    root = ET.Element("project", SPACES)
    _headers(root, design)
    pous = ET.SubElement(types := ET.SubElement(root, "types"), "pous")
    types.insert(0, ET.Element("dataTypes"))
    inputs, outputs = _signals(design, values)
    told = f"{CALL} {'. '.join(map(str, values['head']))}"
    each = {"inputVars": [("reset", "BOOL", None, "forgets the past"), *inputs]}
    each |= {"outputVars": outputs, "localVars": [*_locals(values)]}
    _pou(
        pous,
        name,
        "functionBlock",
        each,
        rendered("body.st.j2", design, template.places, **values),
        told,
    )
    own = {"localVars": [(instance, name, None, "the controller"), *inputs, *outputs]}
    _pou(pous, program, "program", own, _call(instance, list(values["signals"])), EXAMPLE)
    _instances(root, program, design.controller.sample_time_s)
    ET.indent(root, " ")
    head = '<?xml version="1.0" encoding="utf-8"?>\n'
    return f"{head}{ET.tostring(root, encoding='unicode')}\n"


def _headers(root: ET.Element, design: Design) -> None:
    product = {"companyName": "hfc-design", "productName": "hfc-design"}
    product |= {"productVersion": __version__, "creationDateTime": CREATED}
    ET.SubElement(root, "fileHeader", product)
    content = ET.SubElement(root, "contentHeader", {"name": harmless(design.name)})
    ET.SubElement(content, "Comment").text = harmless("; ".join(facts(design)))
    pages = ET.SubElement(content, "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        ET.SubElement(ET.SubElement(pages, language), "scaling", {"x": "1", "y": "1"})


def _signals(design: Design, values: Json) -> tuple[list[Variable], list[Variable]]:
    """What comes in, and command and fault, with their units."""
    meanings = signal_meanings(design)

    def told(name: str, unit: str) -> str:
        return ", ".join(part for part in (meanings.get(name, ""), unit and f"[{unit}]") if part)

    inputs: list[Variable] = [
        (name, "LREAL", None, told(name, unit)) for name, unit in values["signals"].items()
    ]
    unit = signal_units(design).get("command", "")
    command: Variable = ("command", "LREAL", None, told("command", unit))
    return inputs, [command, ("fault", "BOOL", None, "the command is 0, an input was no number")]


def _locals(values: Json) -> Iterable[Variable]:
    """The variables inside, in the order of ``--to st``."""
    for name, number in values["constants"].items():
        yield name, "LREAL", number, "constant"
    for name in values["remembered"]:
        yield name, "LREAL", 0.0, "remembered from one sample to the next"
    if values["past"]:
        yield "started", "BOOL", None, "whether there was a sample"
    if values["units"]:
        yield from ((name, "INT", None, "") for name in "ij")
        yield from ((f"in_{name}", "LREAL", [0.0] * 7, "degrees") for name in ("column", "row"))
    yield from ((name, "LREAL", None, "within a sample") for name in values["within"])


def _pou(
    pous: ET.Element,
    name: str,
    kind: str,
    variables: Mapping[str, Sequence[Variable]],
    body: str,
    told: str,
) -> None:
    pou = ET.SubElement(pous, "pou", {"name": name, "pouType": kind})
    interface = ET.SubElement(pou, "interface")
    for section, each in variables.items():
        whole = ET.SubElement(interface, section)
        for variable in each:
            _declare(whole, *variable)
    _text(ET.SubElement(ET.SubElement(pou, "body"), "ST"), body)
    _text(ET.SubElement(pou, "documentation"), harmless(told))


def _declare(
    section: ET.Element, name: str, kind: str, first: float | Sequence[float] | None, told: str
) -> None:
    variable = ET.SubElement(section, "variable", {"name": name})
    place = ET.SubElement(variable, "type")
    if isinstance(first, Sequence):
        array = ET.SubElement(place, "array")
        ET.SubElement(array, "dimension", {"lower": "0", "upper": str(len(first) - 1)})
        place = ET.SubElement(array, "baseType")
    known = kind in ("BOOL", "INT", "LREAL")
    ET.SubElement(place, *((kind,) if known else ("derived", {"name": kind})))
    if first is not None:
        _value(ET.SubElement(variable, "initialValue"), first)
    if told:
        _text(ET.SubElement(variable, "documentation"), harmless(told))


def _value(place: ET.Element, value: float | Sequence[float]) -> None:
    if isinstance(value, Sequence):
        array = ET.SubElement(place, "arrayValue")
        for one in value:
            _value(ET.SubElement(array, "value"), one)
    else:
        ET.SubElement(place, "simpleValue", {"value": real(value)})


def _text(place: ET.Element, text: str) -> None:
    """Text as readers look for it: in a paragraph of XHTML."""
    ET.SubElement(place, "xhtml:p").text = text


def _call(instance: str, signals: Sequence[str]) -> str:
    given = "".join(f", {name} := {name}" for name in signals)
    outputs = (f"{name} := {instance}.{name};\n" for name in ("command", "fault"))
    return f"{instance}(reset := FALSE{given});\n{''.join(outputs)}"


def _instances(root: ET.Element, program: str, every: float) -> None:
    """A task that calls the program once a sample, of ``every`` seconds."""
    configurations = ET.SubElement(ET.SubElement(root, "instances"), "configurations")
    whole = ET.SubElement(configurations, "configuration", {"name": "config"})
    resource = ET.SubElement(whole, "resource", {"name": "resource1"})
    interval = f"T#{(Decimal(repr(every)) * 1000).normalize():f}ms"
    task = {"name": "sample", "interval": interval, "priority": "0"}
    of = {"name": "instance0", "typeName": program}
    ET.SubElement(ET.SubElement(resource, "task", task), "pouInstance", of)


def folder(design: Design) -> Content:
    """The project of a design, a page on it, vectors, and a program that runs them.

    Raises:
        UserError: as ``project``.
    """
    return with_vectors(design, {f"{c_name(design)}.xml": project(design)})


PLCOPEN = "a folder with the block of st as PLCopen XML (TC6 2.01), and a task that calls it"
FORMATS = (Format("plcopen", PLCOPEN, folder, beside=page_of_axes),)
