"""Simulation of a population of closed loops, up to a hundred thousand: judgements, trajectories.

Inputs and results are NumPy arrays. ``compiled`` spreads a population over the devices and calls
``stepping``, which simulates it. A *lane* is one individual on one machine.
"""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from itertools import pairwise
from types import MappingProxyType
from typing import Any, NamedTuple

import jax
import numpy as np
from jax.typing import DTypeLike

from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Gains, Integers, Memory, Parameters
from hfc_design.core.plugins import own_code
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Samples
from hfc_design.objectives.judge import Judged
from hfc_design.simulation import compiled, early_stopping
from hfc_design.simulation.closed_loop import Loop, axis_signals
from hfc_design.simulation.stepping import Inputs, Motions, trailing
from plants.around import Around, Standing, plain, sampled

#: Fields of ``Around`` that are set to 0 where they would be negative.
LEAST_0 = ("delay_samples", "lag_s", "noise", "backlash", "jitter")
NOTHING: Mapping[str, Any] = MappingProxyType({})


class Machines(NamedTuple):
    """Machines of the same kind, each with its own parameters."""

    nominal: tuple[Parameters, ...]  # that the control assumes: a record of numbers for each axis
    actual: tuple[Parameters, ...]  # true ones: a record for each axis, leaves (machines,)
    #: Deviations of effects around the drives, (axes, machines) each, see ``standing``.
    around: Mapping[str, Floats] = MappingProxyType({})

    @property
    def size(self) -> int:
        """Number of machines."""
        return trailing(self.actual)

    def take(self, chosen: int | Integers) -> "Machines":
        """Return the machines with these indices; for a single index a machine of plain numbers."""
        true = jax.tree.map(lambda leaf: leaf[chosen], self.actual)
        around = {name: x[..., chosen] for name, x in self.around.items()}
        return Machines(self.nominal, true, around)

    @property
    def each(self) -> tuple[tuple[Parameters, ...], tuple[Parameters, ...]]:
        """Parameters that the control assumes for all machines, and the true ones of each."""
        return self.nominal, self.actual

    @property
    def one(self) -> tuple[tuple[Parameters, ...], tuple[Parameters, ...]]:
        """Assumed and true parameters of the first machine, as numbers."""
        return self.take(0).each


def standing(
    machines: Machines, scenario: Scenario, loop: Loop, more: Mapping[str, Any] = NOTHING
) -> Machines:
    """Return the machines with effects around their drives, if the loop has room for effects.

    The effects in ``scenario``, the deviations of ``machines`` and ``more`` (fields of ``Around``,
    a number or one for each axis) are added up, but factors on the noise are multiplied.
    """
    if not loop.around:
        return machines
    every, waits = scenario.simulation.sample_time_s, len(loop.around[0].waits)
    true = []
    for k, (parameters, base) in enumerate(zip(machines.actual, scenario.around, strict=True)):
        around = base
        for changes in (machines.around, more):
            for name, change in changes.items():
                value = np.asarray(change, float)
                value = value[k] if value.ndim else value
                before = getattr(around, name)
                both = before * value if name == "noise" else before + value
                both = np.maximum(both, 0.0) if name in LEAST_0 else both
                around = around._replace(**{name: both})
        wide = Around(*(np.broadcast_to(np.asarray(x, float), machines.size) for x in around))
        true.append(Standing(plain(parameters), sampled(wide, every, loop.substeps, waits)))
    return Machines(machines.nominal, tuple(true), machines.around)


def one_machine(parameters: tuple[Parameters, ...]) -> Machines:
    """Return one machine with these parameters of its axes, which the control assumes too."""
    true = jax.tree.map(lambda number: np.array([number], np.float64), parameters)
    return Machines(parameters, true)


def scores(
    loop: Loop,
    machines: Machines,
    motions: Sequence[Samples],
    gains: Gains,
    dtype: DTypeLike = np.float32,
    at_once: int = 0,
    steps: int = 0,
) -> Judged:
    """Return the judge's results of every individual on every machine in every motion.

    Merits and failures are (individuals, machines, motions); values have a further axis for
    objectives and metrics; all are in float64. ``gains`` is the controller's record, with the
    individuals in the trailing axis of every leaf. The work is spread over all devices.

    ``at_once`` pairs of an individual and a machine are simulated together (0: all); a fixed number
    lets any number of individuals and machines share a compiled program. Likewise, calls with as
    many motions share a program if the total length of the motions is at most ``steps``.
    """
    count, each = trailing(gains), machines.size
    lanes = count * each
    width = compiled.filled(at_once or lanes)
    code, data = loop.apart
    # For a single motion: a loop of fixed length is up to a tenth faster, but a program of its own.
    joined = len(motions) > 1 or steps > 0
    samples, bounds = _joined(motions, least=steps) if joined else (motions[0], None)
    parts, before = [], None  # what all lanes share is packed once
    with own_code_of(loop), jax.enable_x64(True):
        for start in range(0, lanes, width):
            lane = np.minimum(np.arange(start, start + width), lanes - 1)  # padded with the last
            some = gains if lanes == width == count else _lanes_of(gains, lane // each)
            true = machines.take(lane % each if each > 1 else 0).actual
            inputs = Inputs(data, machines.nominal, true, samples, some, bounds)
            numbers = inputs.packed(each > 1, dtype, compiled.together(width), before)
            before = numbers[:2]
            parts.append(np.asarray(compiled.scores(code, each > 1, *numbers), np.float64))
    outputs = np.concatenate(parts, axis=-1)[..., :lanes]
    outputs = outputs.reshape(len(outputs), len(motions), count, each)
    merit, failed, *values = np.moveaxis(outputs, 1, -1)
    return Judged(merit, np.stack(values, axis=-1), failed > 0.0)


def scores_needed(
    loop: Loop,
    machines: Machines,
    samples: Samples,
    gains: Gains,
    needed: Floats,
    dtype: DTypeLike = np.float32,
    at_once: int = 0,
) -> tuple[Judged, Floats]:
    """Return the judge's results on one machine, and the number of simulated samples of each.

    The results are those of ``scores``, bit by bit, except that an individual is stopped once it
    can no longer reach its merit in ``needed`` (individuals,). Its merit is then the best that it
    could still have reached, and its values mean nothing.

    ``at_once`` individuals are simulated together (0: all); a fixed number lets populations of any
    size share a compiled program.
    """
    count = trailing(gains)
    bounds = early_stopping.bounds(len(samples.time))
    samples, _ = _joined([samples])
    width = compiled.filled(at_once or count)
    # Individuals go to the devices in turn: neighbours are similar, and often stopped together.
    dealt = np.arange(width).reshape(-1, jax.device_count()).T.ravel()
    code, data = loop.apart
    parts, before = [], None
    with own_code_of(loop), jax.enable_x64(True):
        for start in range(0, count, width):
            indices = start + dealt
            lane = np.minimum(indices, count - 1)  # lanes that fill up are stopped at once
            least = np.where(indices < count, needed[lane], np.inf)
            some = _lanes_of(gains, lane)
            inputs = Inputs(data, *machines.one, samples, some, bounds, least)
            numbers = inputs.packed(False, dtype, compiled.finely(width), before)
            before = numbers[:2]
            outputs = np.asarray(compiled.scores_needed(code, *numbers), np.float64)
            parts.append(outputs[:, np.argsort(dealt)])
    outputs = np.concatenate(parts, axis=1)[:, :count, None, None]
    merit, failed, simulated, *values = outputs
    return Judged(merit, np.stack(values, axis=-1), failed > 0.0), simulated[:, 0, 0]


def _lanes_of(gains: Gains, chosen: Integers) -> Gains:
    return jax.tree.map(lambda leaf: np.take(leaf, chosen, axis=-1), gains)


def trajectories(
    loop: Loop,
    machines: Machines,
    motions: Sequence[Samples],
    gains: Gains,
    recorded: int | None = None,
) -> list[tuple[Judged, Motions, Memory]]:
    """Return for each motion the judge's results, all movements, and the final controller memories.

    They are NumPy arrays in float64. All individuals are on the only machine, or each is on a
    machine of its own. All are judged, but movements and memories are those of the first
    ``recorded`` (None: all). Lengths with equal ``compiled.filled_up_steps`` share a program.
    """
    recorded = trailing(gains) if recorded is None else recorded
    separate, (code, data) = machines.size > 1, loop.apart
    samples, bounds = _joined(motions, recorded)
    inputs = Inputs(data, *(machines.each if separate else machines.one), samples, gains, bounds)
    with own_code_of(loop), jax.enable_x64(True):
        judged, moved, memory = jax.tree.map(
            np.asarray, compiled.trajectories(code, separate, recorded, inputs.cast(np.float64))
        )
    ends = np.cumsum([0, *(len(motion.time) for motion in motions)])
    parts = [slice(*span) for span in pairwise(ends)]
    return [(_at(judged, k), _at(moved, part), _at(memory, k)) for k, part in enumerate(parts)]


def _at(tree: Any, index: int | slice) -> Any:
    """Return each leaf at an index; small leaves are copied, so that the padded array is freed."""

    def taken(leaf: Floats) -> Floats:
        return leaf[index].copy() if leaf.size <= compiled.RECORDED else leaf[index]

    return jax.tree.map(taken, tree)


def largest_signals(
    loop: Loop, machines: Machines, motions: Sequence[Samples], gains: Gains
) -> dict[str, float]:
    """Return the largest magnitude of each signal of the first axis over all motions.

    One individual controls the first machine, in float64; the drive's own sensors read the signals.
    """
    largest: dict[str, float] = {}
    drive, nominal = loop.machine.drives[0], machines.take(np.zeros(1, int))
    fixed = drive.coefficients(machines.nominal[0])
    each = trajectories(loop, nominal, motions, gains)
    for samples, (_, moved, _) in zip(motions, each, strict=True):
        axis_motion = jax.tree.map(lambda leaf: leaf[..., 0], moved[0])
        seen = axis_signals(drive, fixed, drive.measured(fixed, axis_motion.state), samples.axes[0])
        for name, values in seen.items():
            largest[name] = max(largest.get(name, 0.0), float(np.nanmax(np.abs(values))))
    return largest


def jacobians(
    loop: Loop,
    machines: Machines,
    samples: Samples,
    gains: Gains,
    quantities: tuple[str, ...],
    dtype: DTypeLike = np.float32,
    chosen: Integers | None = None,
) -> dict[str, tuple[Floats, Floats]]:
    """Return ``quantities`` of ``Recorded`` (steps,), each with its derivative (steps, chosen).

    One individual moves the first machine. The derivative is by the parameters with the indices
    ``chosen`` (None: all); parameters are the numbers in the floating leaves of ``gains`` (trailing
    axis 1) in order. It is computed in forward mode on a population with a copy for each parameter.
    """
    if chosen is None:
        sizes = [leaf.size for leaf in jax.tree.leaves(gains) if leaf.dtype.kind == "f"]
        chosen = np.arange(sum(sizes))
    code, data = loop.apart
    with own_code_of(loop), jax.enable_x64(True):
        inputs = Inputs(data, *machines.one, samples, gains).cast(dtype)
        values, slopes = compiled.jacobians(code, quantities, inputs, compiled.filled_up(chosen))
    count = len(chosen)
    return {
        name: (np.asarray(value[:, 0], np.float64), np.asarray(slope[:, :count], np.float64))
        for name, value, slope in zip(quantities, values, slopes, strict=True)
    }


def own_code_of(loop: Loop, doing: str = " cannot be simulated") -> AbstractContextManager[None]:
    """Return a context that turns an error of a user's own part of the loop into a line."""
    parts = [("plant", drive.name) for drive in loop.machine.drives]
    parts += [("plant", loop.machine.name), ("controller", loop.controller.kind)]
    parts += [("fitness", objective.name) for objective in loop.judge.objectives]
    no_memory = jax.errors.JaxRuntimeError  # among others
    devices.make_room()
    return own_code(doing, *parts, passing=(no_memory,))


def _joined(
    motions: Sequence[Samples], recorded: int = 0, least: int = 0
) -> tuple[Samples, Integers]:
    """Return the motions in a row, padded at the end, and begin and end of each, (motions, 2)."""
    columns = [motion._replace(sample_time=None, start=(), copy_start=()) for motion in motions]
    ends = np.cumsum([0, *(len(motion.time) for motion in motions)])
    behind = np.full(compiled.filled_up_steps(max(int(ends[-1]), least), recorded) - ends[-1], -1)

    def joined(*parts: Floats) -> Floats:
        return np.concatenate([*parts, parts[-1][..., behind]], axis=-1)

    whole = jax.tree.map(joined, *columns)
    starts = [(motion.start, motion.copy_start) for motion in motions]
    start, copy_start = jax.tree.map(lambda *each: np.array(each), *starts)
    one = {"sample_time": motions[0].sample_time, "start": start, "copy_start": copy_start}
    return whole._replace(**one), np.stack([ends[:-1], ends[1:]], axis=1)
