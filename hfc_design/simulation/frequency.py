"""Frequency response of a design's loop as simulated, on its nominal machine and on others."""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np

from hfc_design.core.numbers import Floats, Gains
from hfc_design.core.records import UserError, option
from hfc_design.core.wording import three_digits
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import (
    controller_of,
    load_design,
    machine,
    own_scenario,
    with_converter,
)
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.robust import RobustSettings
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.loop_margins import Point, near, operating_points, steady_row
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import Machines, standing
from hfc_design.simulation.sensors import largest_command
from hfc_design.simulation.stepped_sines import Answers, Sines, stepped_sines, whole_periods
from hfc_design.simulation.usable import BEYOND, SPREAD
from hfc_design.stability.frequency import FrequencyResponse, response_units

#: Amplitudes of the sines, as shares of the largest command; the machines get the middle one.
SHARES = (0.01, 0.03, 0.1)
#: Number of corrections of the load's amplitude, which is to move the command by the same amount.
CORRECTIONS = 2


class Setup(NamedTuple):
    """The loop of a design, its machines, and the steady motion in which an axis is excited."""

    name: str  # of the design, and of the axis if there are several
    scenario: Scenario
    loop: Loop
    gains: Gains
    machines: Machines  # the nominal one first
    point: Point
    fastest: Point  # of the scenario, by this axis
    axis: int
    bare: Machines  # those machines without effects around their drives

    @classmethod
    def of(
        cls,
        design: AnyDesign,
        scenario: AnyScenario | None,
        axis: str | None,
        speed: float | None,
        machines: int,
        later: float | None = None,
    ) -> "Setup":
        """Return the setup; ``later``: see ``closed_loop``; else see ``simulated_response``."""
        design = load_design(design)
        where = load_scenario(scenario) if scenario else own_scenario(design, design.name)
        where = with_converter(where, design)
        axes = where.machine.axes
        if axis is not None and axis not in axes:
            raise UserError(f"{option('axis', axis)}: must be one of {', '.join(axes)}")
        number = axes.index(axis) if axis else 0
        controller, gains = controller_of(design, where)
        loop = closed_loop(where, controller, later)
        robust = where.robust or RobustSettings(spread=SPREAD)
        draw = (robust.spread, machines, where.run.seed + BEYOND, robust.tolerances)
        some, _ = drawn(machine(design, where), *draw, key="robust.spread")
        point = fastest = max(operating_points(where), key=lambda one: abs(one.speeds[number]))
        if speed is not None:
            motion = where.each_motion()[0]
            speeds = tuple(speed if k == number else 0.0 for k in range(len(axes)))
            point = Point("", steady_row(motion, motion.samples(), 0, speeds), speeds)
        name = f"{design.name} {axes[number]}" if len(axes) > 1 else design.name
        around = standing(some, where, loop)
        return cls(name, where, loop, gains, around, point, fastest, number, some)

    @property
    def every(self) -> float:
        """Sample time [s]."""
        return self.scenario.simulation.sample_time_s

    @property
    def largest(self) -> float:
        """The largest command; without a limit, that which the fastest motion needs.

        Raises:
            UserError: there is neither.
        """
        drive, axis = self.scenario.machine.drives[self.axis], self.scenario.machine.axes[self.axis]
        limit = largest_command(self.scenario.limits.of(axis))
        largest = drive.largest_commands(self.machines.nominal[self.axis], limit)[1]
        if not np.isfinite(largest):
            about = near(self.loop, self.machines.take(np.zeros(1, int)), [self.fastest])
            largest = float(np.abs(about.commands[0, self.axis]))
        if not largest > 0.0:
            given = option("amplitude", ..., "amplitudes")
            raise UserError(f"{given}: is missing, as the command has no limit")
        return largest

    def sines(self, chosen: Floats, command: Floats, load: Floats, count: int) -> Answers:
        """Return the answers of the chosen machines to sines of these amplitudes."""
        some, periods = self.machines.take(np.asarray(chosen, int)), whole_periods(count)
        sines = Sines(command, load, np.zeros((some.size, len(periods))))
        row, speeds = self.point.row, self.point.speeds
        return stepped_sines(self.loop, some, self.gains, row, speeds, sines, self.axis, periods)


def simulated_response(
    design: AnyDesign,
    scenario: AnyScenario | None = None,
    *,
    axis: str | None = None,
    speed: float | None = None,
    amplitudes: Sequence[float] = (),
    machines: int = 200,
    frequencies: int = 40,
) -> list[FrequencyResponse]:
    """Return the frequency responses of a design's loop at several amplitudes, by stepped sines.

    Args:
        design: the design.
        scenario: its machine, sensors and limits; default: that the design was made for.
        axis: name of the axis that is excited; default: the first.
        speed: of that axis during the measurement [unit of its position per s]; default: the
            highest of the scenario's motions. Friction acts linearly only while the axis moves.
        amplitudes: of the sines on the command [its unit]; default: ``SHARES`` of the largest
            command. The machines get the middle one, the nominal machine all.
        machines: number of machines within the tolerances of the scenario.
        frequencies: number of frequencies, evenly on a logarithmic scale.

    Raises:
        UserError: design and scenario do not fit, the axis is unknown, or the command has no limit
            and no amplitude is given.
    """
    setup = Setup.of(design, scenario, axis, speed, machines)
    sizes = sorted(amplitudes) or [x * setup.largest for x in SHARES]
    middle = (len(sizes) - 1) // 2
    chosen = np.r_[np.arange(machines + 1), np.zeros(len(sizes) - 1, int)]
    others = sizes[:middle] + sizes[middle + 1 :]
    command, load = np.r_[np.full(machines + 1, sizes[middle]), others], 1.0
    for _ in range(CORRECTIONS):
        first = setup.sines(np.zeros(1), command[:1], np.array([load]), frequencies)
        with np.errstate(all="ignore"):  # nothing moves, or the loop diverges
            more = float(np.abs(first.added / first.resisting).min())
        load *= more if np.isfinite(more) and more > 0.0 else 1.0
    answers = setup.sines(chosen, command, command * load / command[0], frequencies)
    begins = [*range(machines + 1, machines + 1 + len(others))]
    parts = [slice(k, k + 1) for k in begins]
    parts.insert(middle, slice(machines + 1))
    return [_response(setup, answers, x, part) for x, part in zip(sizes, parts, strict=True)]


def _response(setup: Setup, answers: Answers, size: float, part: slice) -> FrequencyResponse:
    """Return the response from the answers of some cases, to sines of a ``size``."""
    some: Answers = jax.tree.map(lambda leaf: leaf[part] if leaf.ndim > 1 else leaf, answers)
    units = setup.scenario.units.signals
    with np.errstate(all="ignore"):
        return FrequencyResponse(
            f"{setup.name} {three_digits(size)} {units['command']}",
            some.hertz,
            setup.every,
            some.seen / some.command,
            some.share[0],
            response_units(units),
            -some.answer / some.command,
            some.moved / some.load,
        )
