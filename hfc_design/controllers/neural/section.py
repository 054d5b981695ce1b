"""Report section of a neural controller: its numbers, and its command as designed and learned."""

from functools import partial

import numpy as np

from hfc_design.controllers.kind import ReportContext, last_memory
from hfc_design.controllers.neural.record import NeuralDesign, command, inputs_of
from hfc_design.controllers.surfaces import Side
from hfc_design.core.numbers import Floats
from hfc_design.core.tables import Table
from hfc_design.plotting import units
from hfc_design.plotting.numbers import readable
from hfc_design.plotting.section import Drawing, Drawn, Section
from plants import Drive

ABOUT = (
    "A network reads the error of its axis and the change of that since the last sample, and gives "
    "the command. On line it learns from every sample by back-propagation."
)
#: End of the range of the inputs if no motion gives one.
REACH = 10.0


def sections(record: NeuralDesign, shown: ReportContext) -> list[Section]:
    """Return a section: numbers of the network, its command as designed and after the motion."""
    position, volts = shown.units["error"], shown.units["command"]
    rows = [
        ["hidden units", f"{len(record.weights.hidden)}", ""],
        ["error of an input of 1", f"{record.error_unit:.4g}", position],
        ["change of the error in a sample of an input of 1", f"{record.change_unit:.4g}", position],
        ["command of an output of 1", f"{record.command_unit:.4g}", volts],
        ["rate of learning on line", f"{record.rate:.4g}", ""],
        ["momentum", f"{record.momentum:.4g}", ""],
        ["slope of the hidden units", f"{record.slope:.4g}", ""],
        ["weight of the change in the training error", f"{record.xi:.4g}", ""],
    ]
    listing = Table("The network.", ["number", "value", "unit"], rows)
    input_limits = _ranges(record, shown)
    drawings = [_drawing(record, input_limits, "as designed", shown)]
    for axis, after in at_the_end(record, shown).items():
        name = axis if len(shown.machine.axes) > 1 else "the axis"
        drawings.append(_drawing(after, input_limits, f"of {name} after the motion", shown))
    return [Section("The controller", ABOUT, listing, drawings)]


def at_the_end(record: NeuralDesign, shown: ReportContext) -> dict[str, NeuralDesign]:
    """Return {axis: the network that has learned in the motion}; {} if none can learn."""
    each = shown.signals or {}
    limits = shown.largest or (None,) * len(each)
    pairs = zip(each.items(), limits, strict=True)
    designs = {x: record.adapted(last_memory(record, y, limit)) for (x, y), limit in pairs}
    return {axis: after for axis, after in designs.items() if after is not None}


def pictures(record: NeuralDesign, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """Return pictures for ``hfc plot``: the command over the inputs, without later learning."""
    about = _surface(record, np.array([REACH, REACH]), drive.units, "network")
    draws = {"surface": units.surface, "surface-3d": units.solid}
    return {what: {"network": partial(draw, *about)} for what, draw in draws.items()}


def _ranges(record: NeuralDesign, shown: ReportContext) -> Floats:
    """Return the largest input of each kind (2,) in the motion, or ``REACH`` if not known."""
    if not shown.signals:
        return np.array([REACH, REACH])
    errors = np.stack([signals["error"] for signals in shown.signals.values()], axis=1)
    largest = np.abs(inputs_of(record, errors)).max(axis=(0, 1))
    return np.where(largest > 0.0, largest, REACH)


def _drawing(
    record: NeuralDesign, input_limits: Floats, which: str, shown: ReportContext
) -> Drawing:
    unit = shown.units["command"]
    return Drawing(
        units.surface(*_surface(record, input_limits, shown.units, f"network {which}")),
        f"Heat map of the command of the network {which}",
        f"Command [{unit}] of the network {which}, over the error and its change in a sample.",
    )


def _surface(
    record: NeuralDesign, input_limits: Floats, drive_units: dict[str, str], title: str
) -> tuple[Floats, Floats, Floats, tuple[str, str], str, str]:
    """Return the arguments of ``units.surface``: the command over inputs up to their limits."""
    sizes = {"error": record.error_unit, "change of the error in a sample": record.change_unit}
    sides = []
    for (name, size), largest in zip(sizes.items(), input_limits.tolist(), strict=True):
        factor, unit = readable(drive_units["error"], size * largest)
        end = factor * size * largest
        sides.append(Side(name, unit, (-end, end), 1.0 / (factor * size)))
    x, y = sides
    inputs = np.meshgrid(x.enters * x.points, y.enters * y.points)
    values, label = (
        command(record, np.stack(inputs, axis=-1)),
        f"command [{drive_units['command']}]",
    )
    return x.points, y.points, values, (x.label, y.label), title, label
