"""Limit cycles of a loop at rest: the prediction by describing functions, beside a simulation.

The describing function is not that of a single element but of the whole loop, opened at its
command: a sine of amplitude A drives the machine, and the first harmonic of what the controller
answers gives L(A, f), with gaps, friction, encoder steps and a fuzzy law in it. A limit cycle is
predicted where L = -1. It is stable if |L| falls with A there: a larger oscillation then decays.
Near a stable one the sine gets the overtones of the answer, a few times over (harmonic balance): a
command that jumps between its limits moves an axis with friction farther than its sine alone.
(Gelb & Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, 1968, ch. 3)
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from hfc_design.core.numbers import Floats
from hfc_design.files.design import AnyDesign
from hfc_design.files.named_scenario import AnyScenario
from hfc_design.simulation.following import followed
from hfc_design.simulation.frequency import WINDOW, Setup, Sines, stepped_sines, whole_periods
from hfc_design.stability.frequency import LimitCycle
from hfc_design.stability.margins import between

#: Smallest and largest amplitude, as shares of the largest command, and their number; number of
#: frequencies.
AMPLITUDES, FREQUENCIES = (2e-3, 50.0, 40), 48
#: Ratio of the ends of each finer grid to its middle; its amplitudes and frequencies; overtones.
NEAR, CLOSE, OVERTONES = (1.4, 1.2, 1.1, 1.1), (12, 24), 8
#: Periods of a reference that starts the simulated oscillation, until it has settled, and measured.
KICKED, SETTLED, MEASURED = 6, 40, 20
#: Amplitudes of that reference, as factors on the predicted one; share that counts as sustained.
KICKS, SUSTAINED = (1.0, 3.0, 10.0), 0.02


def limit_cycles(
    design: AnyDesign, scenario: AnyScenario | None = None, axis: str | None = None
) -> list[LimitCycle]:
    """Return the limit cycles of a design's loop at rest, on its nominal machine.

    For the arguments and errors see ``calls.frequency.frequency``.
    """
    setup = Setup.of(design, scenario, axis, 0.0, 0)
    amplitudes = np.geomspace(*AMPLITUDES) * setup.largest
    cycles = [one for one, _ in _predicted(setup, amplitudes, whole_periods(FREQUENCIES))]
    return [_simulated(setup, _closer(setup, one)) if one.stable else one for one in cycles]


def _closer(setup: Setup, cycle: LimitCycle) -> LimitCycle:
    """Return the cycle from finer grids around it, with overtones."""
    overtones: Sequence[complex] = [0j] * OVERTONES
    for end in NEAR:
        amplitudes = np.geomspace(1.0 / end, end, CLOSE[0]) * cycle.driven
        periods = np.geomspace(1.0 / end, end, CLOSE[1]) * cycle.hz * WINDOW * setup.every
        near = _predicted(setup, amplitudes, periods, overtones)
        stable = [one for one in near if one[0].stable]
        apart = [abs(np.log(one.hz / cycle.hz)) for one, _ in stable]
        if stable:
            cycle, overtones = stable[np.argmin(apart)]
    return cycle


def _predicted(
    setup: Setup, amplitudes: Floats, periods: Floats, overtones: Sequence[complex] = ()
) -> list[tuple[LimitCycle, Sequence[complex]]]:
    """Return where L = -1 between neighbouring amplitudes and frequencies.

    ``overtones`` are those of the command, see ``Sines``; those of the answer come with each cycle.
    """
    some = setup.machines.take(np.zeros(len(amplitudes), int))
    shift = np.zeros((len(amplitudes), len(periods)))
    for _ in range(2):  # the second time about the place where the sine moves the axis to and fro
        sines = Sines(amplitudes, None, shift, tuple(0j * amplitudes + x for x in overtones))
        answers = stepped_sines(setup, some, sines, periods, opened=True)
        shift = shift + answers.middle
    with np.errstate(all="ignore"):
        loop = -answers.answer / answers.added
        crossed, share = between(loop.imag)
        size = -(loop.real[:, :-1] + share * np.diff(loop.real))
        crossed &= size > 0.0
        scale = amplitudes[:, None] / np.abs(answers.added)
        hertz = np.broadcast_to(answers.hertz, loop.shape)
        each = [np.log(np.abs(x)) for x in (hertz, answers.command * scale, answers.seen * scale)]
        each = [x[:, :-1] + share * np.diff(x) for x in each]
        size = np.log(size)
    cycles = list[tuple[LimitCycle, Sequence[complex]]]()
    for k, n in zip(*np.nonzero(crossed[:-1]), strict=True):
        others = np.flatnonzero(crossed[k + 1])
        if not others.size:
            continue
        # The same crossing at the next amplitude: the nearest in frequency.
        m = others[np.abs(each[0][k + 1, others] - each[0][k, n]).argmin()]
        one, two = size[k, n], size[k + 1, m]
        if (one > 0.0) != (two > 0.0):
            way = one / (one - two)
            pairs = [(np.log(amplitudes[k]), np.log(amplitudes[k + 1]))]
            pairs += [(x[k, n], x[k + 1, m]) for x in each]
            driven, hz, command, position = (float(np.exp(x + way * (y - x))) for x, y in pairs)
            first, higher = answers.answer[k, n], answers.overtones[:, k, n]
            back = np.exp(-1j * np.angle(first / answers.added[k, n]))
            shares = [x / abs(first) * back ** (2 + h) for h, x in enumerate(higher)]
            one = LimitCycle(hz, command, position, driven, bool(two < one))
            cycles.append((one, shares))
    return cycles


def _simulated(setup: Setup, cycle: LimitCycle) -> LimitCycle:
    """Return a cycle with what remains of an oscillation that a sine of the reference started."""
    every, nominal = setup.every, setup.machines.take(np.zeros(1, int))
    period = 1.0 / (cycle.hz * every)
    steps = int((KICKED + SETTLED + MEASURED) * period) + 1
    swing = np.where(np.arange(steps) < KICKED * period, np.arange(steps) / period, 0.0)
    best = cycle
    for kick in KICKS:
        reference = kick * cycle.position * np.sin(2.0 * np.pi * swing)
        commands, places = followed(setup, nominal, reference, 0.0 * reference)
        last = slice(-int(MEASURED * period), None)
        hz, position = _oscillation(places[last, 0], every, cycle.hz)
        _, command = _oscillation(commands[last, 0], every, hz)
        if position > SUSTAINED * cycle.position and not position < best.simulated_position:
            best = best._replace(
                simulated_hz=hz, simulated_command=command, simulated_position=position
            )
    return best


def _oscillation(values: Floats, every: float, near: float) -> tuple[float, float]:
    """Return frequency [Hz], within a half of ``near``, and amplitude of the largest sine."""
    window = np.hanning(len(values))
    off = (values - np.average(values, weights=window)) * window
    time = every * np.arange(len(values))

    def amplitude(hz: float) -> float:
        return float(2.0 * np.abs(off @ np.exp(-2j * np.pi * hz * time)) / window.sum())

    tried = np.linspace(0.5 * near, 1.5 * near, 8 * MEASURED)
    step = tried[1] - tried[0]
    first = max(tried, key=amplitude)
    ends = (first - step, first + step)
    hz = float(minimize_scalar(lambda x: -amplitude(x), bounds=ends, method="bounded").x)
    return hz, amplitude(hz)
