"""The closed loop that recorded a log, under the reference and the load that it recorded."""

from typing import NamedTuple

import jax
import numpy as np

from hfc_design.controllers.controller import Controller, Stepped, View
from hfc_design.core.numbers import Gains, Memory, Parameters, Scalar, Xp
from hfc_design.files.design import Design
from hfc_design.files.pairing import controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import (
    Residual,
    between,
    curved,
    read,
    rigid,
    shifted,
    unzeroed,
    zeros,
)
from hfc_design.motion.samples import AxisSamples, Samples
from hfc_design.simulation.closed_loop import Moving, closed_loop, moved, start


class Pushed(NamedTuple):
    """A controller to whose command something is added."""

    controller: Controller
    more: Scalar

    @property
    def kind(self) -> str:
        """Name of the kind."""
        return self.controller.kind

    def initial_memory(self, zero: Scalar) -> Memory:
        """Memory before the first sample."""
        return self.controller.initial_memory(zero)

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """The command of the axis, and what to remember."""
        commands, memory = self.controller.step(xp, gains, memory, view)
        return tuple(command + self.more for command in commands), memory


def loop(scenario: Scenario, design: Design, told: Recording) -> Residual:
    """How far the loop of a machine is off what was recorded, where that counts.

    Sensors, limits and substeps are those of ``scenario``, without the steps of encoders.
    """
    controller, gains = controller_of(design, scenario)
    one = closed_loop(scenario, controller).smooth
    own: object = jax.tree.map(lambda leaf: leaf[..., 0], gains)
    drive, every = one.machine.drives[0], told.sample_time
    believed = scenario.plant.values()
    body = rigid(drive, believed[0])
    rows = _rows(told, one.substeps, len(drive.encoders) + _readings(scenario))
    outputs = np.stack([*told.outputs.values()], axis=-1)
    usable, unknown = told.usable, zeros(dict(body), told.outputs, [drive.seen[0]])

    def off(parameters: Parameters, late: Scalar) -> Scalar:
        fixed = one.coefficients((parameters,))
        zero = 0.0 * late
        put = shifted(body, drive.initial_state(zero), told.place[0], told.rate)
        before = start(one, zero, (put,))

        def sample(
            before: Moving, row: tuple[AxisSamples, Scalar, Scalar, Scalar]
        ) -> tuple[Moving, Scalar]:
            happens, shown, counts, more = row
            missing = shown - read(drive, fixed[0], before.states[0], told.outputs)
            sampled = Samples((happens,), None, 0.0, every, 0.0, 0.0, (), ())
            pushed = one._replace(controller=Pushed(controller, more))
            after = moved(pushed, believed, fixed, every, own, before, sampled)
            return after, missing * counts

        off = jax.lax.scan(sample, before, (rows, outputs, usable, told.added))[1]
        return unzeroed(off, usable, unknown)

    return jax.tree_util.Partial(off)


def _readings(scenario: Scenario) -> int:
    axis = scenario.plant.machine.axes[0]
    return len(scenario.sensors.of(axis).readings)


def _rows(told: Recording, substeps: int, noises: int) -> AxisSamples:
    """What happens to the axis, a leaf (steps,) each."""
    assert told.reference is not None
    steps, every = len(told.load), told.sample_time
    reference = told.reference
    faster = np.diff(reference, 2, prepend=reference[0], append=reference[-1])
    rate = np.gradient(reference, every)  # where it is, not half a sample later
    rise, bend = between(told.load)
    shares = np.arange(2 * substeps + 1) / (2 * substeps)
    loads = tuple(curved(told.load, rise, bend, share) for share in shares)
    still = np.zeros(steps)
    return AxisSamples(
        reference=reference,
        reference_rate=rate,
        loads=loads,
        noise=(still,) * noises,
        target=reference,
        reference_acceleration=faster / every**2,
        sliding=still,
        end=reference,
        heading=still,
    )
