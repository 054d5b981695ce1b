"""PLCopen XML (TC6 2.01) export: the block of ``--to st``, and a task that calls it."""

from decimal import Decimal
from typing import TypeAlias

from hfc_design import __version__
from hfc_design.codegen.st import Variable
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.formats import writing
from hfc_design.formats.code import Flat, c_name
from hfc_design.formats.deployment.folder import page_of_axes
from hfc_design.formats.st import CLASH, FunctionBlock, block_of, with_vectors
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
#: A variable with its description.
Told: TypeAlias = "tuple[Variable, str]"


def project(design: Design) -> str:
    """Return a project as PLCopen XML: block and example program; UserError as for ``block_of``."""
    block = block_of(design)
    program, instance = f"{block.name}_example", f"{block.name}_1"
    names = [block.name, program, instance, *block.known.inputs, *block.known.outputs, "fault"]
    writing.check_names("st", names, CLASH)
    inputs, outputs = _signals(block)
    sections = block.law.sections.items()
    parts: Json = {"name": block.name, "kind": "functionBlock", "body": block.law.body}
    parts["comment"] = f"{CALL} {'. '.join(writing.head(design))}"
    reset = Variable("reset", "BOOL"), "forgets the past"
    local = [(one, what) for what, variables in sections for one in variables]
    parts["variables"] = {"inputVars": [reset, *inputs], "outputVars": outputs, "localVars": local}
    example: Json = {"name": program, "kind": "program", "comment": EXAMPLE}
    controller = (Variable(instance, block.name), "the controller")
    example["variables"] = {"localVars": [controller, *inputs, *outputs]}
    example["body"] = _call(instance, block.known)
    values: Json = {"version": __version__, "facts": writing.facts(design)}
    interval = (Decimal(repr(design.controller.sample_time_s)) * 1000).normalize()
    values |= {"name": design.name, "interval": f"T#{interval:f}ms", "pous": [parts, example]}
    return writing.rendered("plcopen.xml.j2", design, **values)


def _signals(block: FunctionBlock) -> tuple[list[Told], list[Told]]:
    """Return the inputs, and the outputs (commands, then fault), each with a description."""
    known = block.known

    def described(name: str, unit: str) -> Told:
        parts = (known.meanings.get(name, ""), unit and f"[{unit}]")
        kind = "BOOL" if name in known.truths else "LREAL"
        return Variable(name, kind), ", ".join(part for part in parts if part)

    inputs = [described(name, unit) for name, unit in known.inputs.items()]
    fault = Variable("fault", "BOOL"), "the command is 0, an input was no number"
    return inputs, [*(described(name, known.unit) for name in known.outputs), fault]


def _call(instance: str, known: Flat) -> str:
    given = "".join(f", {name} := {name}" for name in known.inputs)
    outputs = (f"{name} := {instance}.{name};\n" for name in (*known.outputs, "fault"))
    return f"{instance}(reset := FALSE{given});\n{''.join(outputs)}"


def folder(design: Design) -> Content:
    """Return the project with what ``st.folder`` adds; UserError as for ``project``."""
    return with_vectors(design, {f"{c_name(design)}.xml": project(design)})


PLCOPEN = "a folder with the block of st as PLCopen XML (TC6 2.01), and a task that calls it"
FORMATS = (Format("plcopen", PLCOPEN, folder, companions=page_of_axes, connects=True),)
