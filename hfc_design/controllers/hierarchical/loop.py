"""The loop of a hierarchy on a linear part: that part, and the slopes of the tables.

Where the root scales a law too, that counts as much as the root gives where all inputs are 0, and
a slope as much as that law gives there (product rule): what it feeds forward of a load.
"""

from functools import partial

import numpy as np

from hfc_design.controllers.controller import FOLLOWED
from hfc_design.controllers.hierarchical.law import PREVIOUS, memberships, outputs
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.controllers.linear.code import TURNING
from hfc_design.controllers.linear.law import ERRORS
from hfc_design.controllers.linear.model import loop_of
from hfc_design.controllers.linear.record import LinearDesign
from hfc_design.core.numbers import ARRAYS, Floats, Parameters
from hfc_design.core.records import UserError
from hfc_design.stability.margins import OpenLoop
from hfc_design.stability.nominal import nominal
from plants import Drive

#: Half the way between two points of a slope, in shares of the universe.
STEP = 1e-5
ABOUT = "Of the linear part, and of the hierarchy by its slopes where all of its inputs are 0"
SCHEDULED = (
    "Of the linear part, of as much of the scheduled law as the root gives and of the hierarchy by "
    "its slopes, where all of its inputs are 0; elsewhere the root gives more or less of that law"
)


def slopes(record: HierarchicalDesign) -> dict[str, float]:
    """How the root's part of the command grows with each input, where all of them are 0.

    In units of the command for a unit of the input; without what a scheduled law grows by.
    """
    moves = STEP * np.eye(len(record.inputs))
    steep = (factor(record, moves) - factor(record, -moves)) / (2.0 * STEP)
    if part := record.scheduled_part:
        steep = steep * part.gains().load
    pairs = zip(record.inputs, steep.tolist(), strict=True)
    return {item.name: item.scale * slope for item, slope in pairs}


def factor(record: HierarchicalDesign, points: Floats) -> Floats:
    """(n,) the root's output, scaled, at (n, inputs) values of the scaled inputs."""
    layout = layout_of(record)
    degrees = partial(memberships, ARRAYS, layout.terms)
    units, _ = outputs(ARRAYS, degrees, layout.reach, record.gains(), list(points.T))
    return np.asarray(record.output_scale * units[-1].output)


def at_rest(record: HierarchicalDesign) -> LinearDesign | None:
    """The linear part, with as much of the scheduled law as the root gives where all inputs are 0.

    Without what axes follow, which is no part of a loop. None: the record has no linear part.
    """
    base, own = record.linear_part, record.scheduled_part
    if base is None or own is None:
        return base
    share = float(factor(record, np.zeros((1, len(record.inputs))))[0])
    signals = dict(base.signals)
    for name, gain in own.signals.items():
        signals[name] = signals.get(name, 0.0) + share * gain
    gains = {key: getattr(base, key) + share * getattr(own, key) for key in ("kp", "ki", "kd")}
    resonators = tuple(
        one.model_copy(
            update={key: getattr(one, key) + share * getattr(other, key) for key in TURNING}
        )
        for one, other in zip(base.resonators, own.resonators, strict=True)
    )
    return base.model_copy(update={**gains, "signals": signals, "resonators": resonators})


def open_loop(record: HierarchicalDesign, drive: Drive, parameters: Parameters) -> OpenLoop | None:
    """The loop on a drive near the speed where that slides, the tables as steep as at rest.

    What the axis follows is no part of it. States are those of ``linear.model`` and each reading
    of the sample before. None: it has no linear part, so that the tables do all of the work, which
    slopes do not describe.

    Raises:
        UserError: the drive cannot be linearised, or does not tell a signal.
    """
    every, base = record.sample_time_s, at_rest(record)
    if base is None:
        return None
    model, now, before = nominal(drive, parameters, every), dict(base.signals), {}
    for name in record.scheduled.signals if record.scheduled else ():
        if name not in model.outputs:
            no_signal = f"controller.scheduled.signals: {name!r} is no signal of the {drive.name}"
            raise UserError(no_signal)
    gains = {"error": base.kp, "error_rate": base.kd}
    for name, slope in slopes(record).items():
        signal = name.removeprefix(PREVIOUS)
        if signal in FOLLOWED:
            continue
        if signal not in model.outputs:
            raise UserError(f"controller.inputs: {signal!r} is no signal of the {drive.name}")
        if name != signal:
            before[signal] = slope
        elif name in ERRORS:
            gains[name] += slope
        else:
            now[name] = now.get(name, 0.0) + slope
    changes = {"kp": gains["error"], "kd": gains["error_rate"], "signals": now}
    loop = loop_of(base.model_copy(update=changes), model, drive, "linear.signals")
    found = _remembering(loop, [model.outputs[name] for name in before], [*before.values()])
    return found._replace(about=SCHEDULED if record.scheduled else ABOUT)


def _remembering(loop: OpenLoop, rows: list[np.ndarray], gains: list[float]) -> OpenLoop:
    """The loop with a gain on each row of its first states as they were a sample before."""
    size, more = len(loop.b), len(rows)
    a = np.zeros((size + more, size + more))
    a[:size, :size] = loop.a
    for k, row in enumerate(rows, size):
        a[k, : len(row)] = row
    b, c = np.append(loop.b, np.zeros(more)), np.append(loop.c, gains)
    return loop._replace(a=a, b=b, c=c)
