"""Model of a design's controller for an FMU, for one axis or a whole machine."""

from itertools import chain

from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import axes_of
from hfc_design.formats import code, saving
from hfc_design.formats.fmu.description import TIME, Model, Variable
from hfc_design.formats.laws import of_path
from hfc_design.formats.writing import each_axis

#: Input -> start value other than 0: the controller is on if the importer does not set ``enable``.
STARTS = {"enable": 1.0}
#: Description of the outputs after a faulty sample.
FAULTY = "the commands are not a number, and the next sample goes on as if this one had not been"
TRIPPED = Variable(
    "tripped", "output", "", "1 where an error was too large, until enable is off", discrete=True
)
#: Names of the path values that a controller of a machine reads.
PATH = ("path.tangent_x", "path.tangent_y", "path.curvature", "path.contour_error")


def commands_machine(design: Design) -> bool:
    """True if the design's controller commands all axes at once."""
    return design.kind.controller is not None and design.kind.axis_records is None


def controller(design: Design) -> Model:
    """Return the model of the controller alone, with the inputs and commands of its C code.

    Raises:
        UserError: in the cases of ``code.sources``.
    """
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
    values = {
        "headers": [f"{called}.h"],
        "state": [f"{called}_state controller"],
        "faulty": FAULTY,
        "controller": called,
        "controllers": [part(design, "controller")],
        "inputs": [[x.name for x in variables] for variables in inputs],
        "outputs": [x.name for x in outputs],
        "tripped": [x.name for x in tripped],
        "whole": whole,
        "path": [x.name for x in path],
    }
    what = f"{design.controller.kind} controller {design.name} for the plant {design.plant.name}"
    every = design.controller.sample_time_s
    return Model(
        "controller", called, what, every, variables, sources, "fmu/controller.c.j2", values
    )


def part(design: Design, member: str) -> Json:
    """Return template values of a controller whose state is a ``member`` of the model's state."""
    values = {"name": code.c_name(design), "member": member, "reads": list(code.signals(design))}
    return values | {"saved": saving.saved(design)}


def path_variables(design: Design) -> list[Variable]:
    """Return the path variables that a controller reads; none if it does not use the path."""
    units, _ = next(iter(each_axis(design).values()))
    unit = units.get("error", "")
    every = [
        Variable(PATH[0], "input", "1", "along X, of the unit vector along the path", 1.0),
        Variable(PATH[1], "input", "1", "along Y, of the unit vector along the path"),
        Variable(PATH[2], "input", unit and f"1/{unit}", "of the path, positive to the left"),
        Variable(PATH[3], "input", unit, "of the measured position, positive to the left"),
    ]
    return every[: len(of_path(design))]
