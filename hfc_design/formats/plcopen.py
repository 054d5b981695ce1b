"""A project of PLCopen's XML (TC6 2.01): the block of ``--to st``, and a task that calls it."""

from collections.abc import Iterable, Sequence
from decimal import Decimal
from typing import TypeAlias

from hfc_design import __version__
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.formats import writing
from hfc_design.formats.code import CLASH, block_values, c_name
from hfc_design.formats.fcl import real
from hfc_design.formats.flash.folder import page_of_axes
from hfc_design.formats.st import with_vectors
from hfc_design.formats.writing import Content, Format

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
    writing.check_names(
        "st", [name, program, instance, *values["signals"], "command", "fault"], CLASH
    )
    inputs, outputs = _signals(design, values)
    block = {
        "name": name,
        "kind": "functionBlock",
        "variables": {
            "inputVars": [("reset", "BOOL", None, "forgets the past"), *inputs],
            "outputVars": outputs,
            "localVars": [*_locals(values)],
        },
        "body": writing.rendered("body.st.j2", design, template.places, **values),
        "told": f"{CALL} {'. '.join(map(str, values['head']))}",
    }
    example = {
        "name": program,
        "kind": "program",
        "variables": {"localVars": [(instance, name, None, "the controller"), *inputs, *outputs]},
        "body": _call(instance, list(values["signals"])),
        "told": EXAMPLE,
    }
    return writing.rendered(
        "plcopen.xml.j2",
        design,
        name=design.name,
        version=__version__,
        facts=writing.facts(design),
        real=real,
        pous=[block, example],
        interval=f"T#{(Decimal(repr(design.controller.sample_time_s)) * 1000).normalize():f}ms",
    )


def _signals(design: Design, values: Json) -> tuple[list[Variable], list[Variable]]:
    """What comes in, and command and fault, with their units."""
    meanings = writing.signal_meanings(design)

    def told(name: str, unit: str) -> str:
        return ", ".join(part for part in (meanings.get(name, ""), unit and f"[{unit}]") if part)

    inputs: list[Variable] = [
        (name, "LREAL", None, told(name, unit)) for name, unit in values["signals"].items()
    ]
    unit = writing.signal_units(design).get("command", "")
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


def _call(instance: str, signals: Sequence[str]) -> str:
    given = "".join(f", {name} := {name}" for name in signals)
    outputs = (f"{name} := {instance}.{name};\n" for name in ("command", "fault"))
    return f"{instance}(reset := FALSE{given});\n{''.join(outputs)}"


def folder(design: Design) -> Content:
    """The project of a design, a page on it, vectors, and a program that runs them.

    Raises:
        UserError: as ``project``.
    """
    return with_vectors(design, {f"{c_name(design)}.xml": project(design)})


PLCOPEN = "a folder with the block of st as PLCopen XML (TC6 2.01), and a task that calls it"
FORMATS = (Format("plcopen", PLCOPEN, folder, beside=page_of_axes),)
