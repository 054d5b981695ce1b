"""How many units of a hierarchy matter for the command. Never imports JAX."""

from collections.abc import Mapping
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.stats import qmc

from hfc_design.controllers.hierarchical.law import HierarchicalGains, Layout, memberships, outputs
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.controllers.linear.law import AHEAD, LinearGains, Structure
from hfc_design.core.numbers import ARRAYS, Floats, Integers

#: A unit matters if replacing its table by a constant changes the command by more than this share.
#: Command and change are root mean squares over the range [-1, 1] of all scaled inputs.
SHARE = 0.05
#: Number of points in this range at which the command is computed; a power of two.
POINTS = 128


def units_that_matter(record: HierarchicalDesign, gains: HierarchicalGains) -> Integers:
    """Return the number (n,) of units that matter in each individual of a population's ``gains``.

    ``record`` gives the terms and the inputs, in the order of ``gains.scales``. A unit matters if
    the command changes by more than the share ``SHARE`` once all numbers of its table are replaced
    by their mean. The command is that of the whole controller, as far as it follows from the
    inputs: without integral, resonators and adaptation.
    """
    layout = layout_of(record)
    points = _universe(len(layout.inputs))
    known = {"error": gains.kp, "error_rate": gains.kd}
    base = known if gains.linear is None else _gains_of(layout.linear, gains.linear)
    factor: Any = layout.output_scale
    if gains.scheduled is not None:
        factor = factor * _said(layout, gains, _gains_of(layout.scheduled, gains.scheduled))
    root = _root(layout, gains, points)
    size = np.sqrt(np.square(_said(layout, gains, base) + factor * root).mean(axis=0))
    counts = np.zeros(root.shape[1], np.int64)
    consequents = np.asarray(gains.consequents)
    for k, table in enumerate(consequents):
        flat = consequents.copy()
        flat[k] = table.mean(axis=(0, 1))
        without = _root(layout, gains._replace(consequents=flat), points)
        counts += np.sqrt(np.square(factor * (without - root)).mean(axis=0)) > SHARE * size
    return counts


@cache
def _universe(inputs: int) -> Floats:
    """Return Sobol points (inputs, POINTS, 1) in [-1, 1]; they are the same in every search."""
    points = 2.0 * qmc.Sobol(inputs, scramble=False).random(POINTS) - 1.0
    return np.asarray(points.T[:, :, None])


def _root(layout: Layout, gains: HierarchicalGains, points: Floats) -> Floats:
    """Return the output (POINTS, n) of the root at ``points`` of the scaled inputs."""
    count = np.asarray(gains.consequents).shape[-1]

    def picked(values: Mapping[int, Floats], index: Integers) -> Floats:
        every = [np.broadcast_to(value, (len(points[0]), count)) for value in values.values()]
        place = np.searchsorted([*values], index)
        return np.asarray(np.stack(every)[place, :, np.arange(count)].T)

    degrees = partial(memberships, ARRAYS, layout.terms)
    xp = ARRAYS._replace(pick=picked)
    units, _ = outputs(xp, degrees, layout.input_range, gains, [*points])
    return np.asarray(units[-1].output)


def _gains_of(law: Structure | None, gains: LinearGains) -> dict[str, Any]:
    """Return the gains of a linear law by signal, feed-forward of velocity and acceleration too."""
    signals = () if gains.signals is None else gains.signals
    names = law.signals if law else ()
    by_signal = {"error": gains.kp, "error_rate": gains.kd}
    by_signal |= dict(zip(names, signals, strict=True))
    for name, gain in zip(AHEAD, (gains.velocity, gains.acceleration), strict=True):
        by_signal[name] = by_signal.get(name, 0.0) + gain
    return by_signal


def _said(layout: Layout, gains: HierarchicalGains, known: dict[str, Any]) -> Floats:
    """Return the command (POINTS, n) of those gains ``known`` whose signals are inputs too."""
    points = _universe(len(layout.inputs))
    commands = np.zeros((len(points[0]), np.asarray(gains.consequents).shape[-1]))
    for name, u, scale in zip(layout.inputs, points, gains.scales, strict=True):
        if name in known:
            commands = commands + known[name] * (u / scale)
    return commands
