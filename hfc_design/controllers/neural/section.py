"""What the page shows of a neural controller: its numbers, its map, what it has learnt on line."""

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers.controller import View
from hfc_design.controllers.kind import Shown
from hfc_design.controllers.neural.record import NeuralDesign
from hfc_design.controllers.neural.training import outputs
from hfc_design.core.numbers import SCALARS, Floats
from hfc_design.pictures.figure import (
    OTHER,
    OWN,
    Drawing,
    Listing,
    Section,
    above,
    finish,
    framed,
)

ABOUT = (
    "One network reads the tracking errors of all axes and gives all commands. On line it learns "
    "from every sample, by back-propagation: the error of an axis stands for that of its output."
)
#: Points of a curve, and errors that are drawn where no motion tells how large they get.
POINTS, REACH = 121, 10.0


def sections(record: NeuralDesign, shown: Shown) -> list[Section]:
    """The numbers; the command of each axis over its error, before and after the motion."""
    position, command = shown.units["error"], shown.units["command"]
    weights = record.weights
    rows = [
        ["inputs and outputs", f"{len(weights.output)}", "axes"],
        ["hidden units", f"{len(weights.hidden)}", ""],
        ["an input of 1 is an error of", f"{record.error_unit:.4g}", position],
        ["an output of 1 is a command of", f"{record.command_unit:.4g}", command],
        ["rate of learning on line", f"{record.rate:.4g}", ""],
        ["momentum", f"{record.momentum:.4g}", ""],
        ["slope of the hidden units", f"{record.slope:.4g}", ""],
    ]
    listing = Listing("The network.", ["number", "value", "unit"], rows)
    after = at_the_end(record, shown)
    drawing = Drawing(
        _curves(record, after, shown),
        "Command of each axis over its error",
        f"Command [{command}] of each axis over its own error [{position}], those of the others "
        "being 0: as the design has it, and dashed after the motion.",
    )
    return [Section("The controller", ABOUT, listing, [drawing])]


def at_the_end(record: NeuralDesign, shown: Shown) -> NeuralDesign | None:
    """The network at the end of the motion, stepped over what the axes measured."""
    if shown.signals is None or not record.rate:
        return None
    axes = shown.machine.axes
    controller, gains = record.controller(dict.fromkeys(axes)), record.gains()
    memory = controller.initial_memory(0.0)
    errors = np.stack([shown.signals[axis]["error"] for axis in axes], axis=1)
    for row in errors.tolist():
        view = View(tuple({"error": error} for error in row))
        _, memory = controller.step(SCALARS, gains, memory, view)
    return record.learnt(axes, memory)


def _curves(record: NeuralDesign, after: NeuralDesign | None, shown: Shown) -> Figure:
    axes = shown.machine.axes
    figure = framed(3.4, top=0.5)
    plot = figure.subplots()
    for k, axis in enumerate(axes):
        reach = REACH * record.error_unit
        if shown.signals is not None:
            reach = float(np.abs(shown.signals[axis]["error"]).max()) or reach
        error = np.linspace(-reach, reach, POINTS)
        color = (OWN, OTHER)[k % 2]
        plot.plot(error, _command(record, k, error), color=color, lw=1.4, label=axis)
        if after is not None:
            told = f"{axis}, after the motion"
            plot.plot(error, _command(after, k, error), color=color, lw=1.2, ls="--", label=told)
    above(figure, plot)
    position, command = shown.units["error"], shown.units["command"]
    finish(plot, f"command [{command}]", f"error [{position}]")
    return figure


def _command(record: NeuralDesign, k: int, error: Floats) -> Floats:
    inputs = np.zeros((len(error), len(record.weights.output)))
    inputs[:, k] = error / record.error_unit
    return record.command_unit * outputs(record, inputs)[:, k]
