"""Model of a design's controller for an FMU, for one axis or a whole machine."""

from itertools import chain

from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import axes_of
from hfc_design.formats import code, saving
from hfc_design.formats.fmu.description import TIME, Model, Variable
from hfc_design.formats.writing import each_axis

#: Input -> start value other than 0: the controller is on if the importer does not set ``enable``.
STARTS = {"enable": 1.0, "path_tangent_x": 1.0}
#: Description of the outputs after a faulty sample.
FAULTY = "the commands are not a number, and the next sample goes on as if this one had not been"
TRIPPED = Variable(
    "tripped", "output", "", "1 where an error was too large, until enable is off", discrete=True
)


def commands_machine(design: Design) -> bool:
    """True if the design's controller commands all axes at once."""
    return design.kind.controller is not None and design.kind.axis_records is None


def controller(design: Design) -> Model:
    """Return the model of the controller alone; UserError in the cases of ``code.sources``."""
    sources = code.sources(design)
    whole, called = commands_machine(design), code.c_name(design)
    read, each = code.signals(design), each_axis(design)
    heads = {f"{identifier(x)}.": x for x in axes_of(design)} if whole else {"": ""}
    inputs: list[list[Variable]] = []
    outputs: list[Variable] = []
    for head, axis in heads.items():
        units, meanings = each.get(axis) or each[""]
        inputs.append([])
        for x in read:
            start, what = STARTS.get(x, 0.0), meanings.get(x, x)
            inputs[-1].append(Variable(f"{head}{x}", "input", units.get(x, ""), what, start))
        unit, meaning = units.get("command", ""), meanings.get("command", "what the drive is to do")
        outputs.append(Variable(f"{head}command", "output", unit, meaning, discrete=True))
    path, tripped = path_variables(design), [TRIPPED] if design.connected else []
    variables = [TIME, *chain(*inputs), *path, *outputs, *tripped]
    names = {"outputs": outputs, "tripped": tripped, "path": path}
    values: Json = {key: [x.name for x in each] for key, each in names.items()}
    values |= {"inputs": [[x.name for x in each] for each in inputs], "faulty": FAULTY}
    values |= {"controller": called, "whole": whole, "controllers": [part(design, "controller")]}
    what = f"{design.controller.kind} controller {design.name} for the plant {design.plant.name}"
    return Model("controller", called, what, variables, sources, values)


def part(design: Design, member: str) -> Json:
    """Return template values of a controller whose state is a ``member`` of the model's state."""
    values = {"name": code.c_name(design), "member": member, "reads": list(code.signals(design))}
    return values | {"saved": saving.saved(design)}


def path_variables(design: Design) -> list[Variable]:
    """Return the path variables that a controller reads; none if it does not use the path."""
    return [
        Variable(name.replace("_", ".", 1), "input", unit, what, STARTS.get(name, 0.0))
        for name, (unit, what) in code.path_inputs(design).items()
    ]
