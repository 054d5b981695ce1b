"""Laps that learn: a signal added to the commands, corrected from lap to lap of the same motion.

Norm-optimal iterative learning control (Amann, Owens and Rogers, IEE Proc. D 143, 1996) in the
frequency domain, with a robustness filter (Bristow, Tharayil and Alleyne, IEEE Control Systems 26,
2006). With the response G from the added signal f to the position, the lap after the one with the
error e minimises, at each frequency,

    |e - G (f' - f)|^2 + w |f'|^2 + SLOW |G|^2 |f' - f|^2

so that f' = Q (f + e / ((1 + SLOW) G)), where Q = (1 + SLOW) |G|^2 / ((1 + SLOW) |G|^2 + w). G is
the median over machines and amplitudes, and w as small as most of them admit: with their
responses the error must shrink to ``SHRINKS`` from lap to lap.
"""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.motion.contour import off_path
from hfc_design.motion.samples import Samples
from hfc_design.simulation.following import AT_ONCE, Moved, moved
from hfc_design.simulation.frequency import Setup, responses
from hfc_design.simulation.monte_carlo import Progress
from hfc_design.simulation.population import Machines

#: Weight of a change from lap to lap; largest share of its error that a lap must leave.
SLOW, SHRINKS = 1.0, 0.9
#: Frequencies at which the loop answers less than this share of its largest answer are not learned.
LEAST = 0.02
#: Share of the responses that the filter suits; with others a lap may be worse, and is not kept.
MOST = 0.8
#: Machines whose responses the filter has to suit, beside the nominal one, their seed; frequencies.
SUITS, SUIT_SEED, FREQUENCIES = 63, 7001, 60
#: Share of a lap in which it fades to 0 after its end, as a jump there would be learned.
FADES = 0.1
#: Up to the frequency where Q falls to this an axis is said to learn.
LEARNS = 0.5


class Filters(NamedTuple):
    """Filters of each axis from one lap to the next."""

    keep: Floats  # (axes, frequencies of the transform) Q
    correct: Any  # complex (axes, frequencies of the transform): Q / (1 + SLOW) / G
    limits: Floats  # (axes, 1) largest command
    hertz: tuple[float, ...]  # up to which each axis learns
    length: int  # of the transform

    def following(self, table: Floats, error: Floats, gain: Floats) -> Floats:
        """Return the signals (..., axes, steps) for the lap after one with ``error``.

        ``gain`` (..., axes, 1) multiplies the corrections.
        """
        before, off = (np.fft.rfft(self._faded(x)) for x in (table, error))
        after = np.fft.irfft(self.keep * before + gain * self.correct * off, self.length)
        return np.clip(after[..., : table.shape[-1]], -self.limits, self.limits)

    def _faded(self, values: Floats) -> Floats:
        """Return values (..., length) that go from the last to 0, and at the end to the first."""
        steps = values.shape[-1]
        share = np.linspace(0.0, 1.0, int(FADES * steps))
        gap = np.zeros((*values.shape[:-1], self.length - steps - 2 * len(share)))
        ends = values[..., -1:] * share[::-1], gap, values[..., :1] * share
        return np.concatenate([values, *ends], axis=-1)


class Kept(NamedTuple):
    """The best lap so far of each axis (..., axes), and the gain of its corrections."""

    table: Floats  # (..., axes, steps) in the lap
    error: Floats  # (..., axes, steps)
    size: Floats  # (..., axes) root mean square of the error
    gain: Floats  # (..., axes)

    @classmethod
    def of(cls, table: Floats, error: Floats) -> "Kept":
        """Return the first lap."""
        size = rms_of(error)
        return cls(table, error, size, np.ones_like(size))

    def after(self, table: Floats, error: Floats) -> "Kept":
        """Return the better lap of each axis; where the new one is worse, the gain is halved."""
        size = rms_of(error)
        better = size < self.size
        lap, gain = better[..., None], np.where(better, self.gain, 0.5 * self.gain)
        chosen = np.where(lap, table, self.table), np.where(lap, error, self.error)
        return Kept(*chosen, np.where(better, size, self.size), gain)

    def following(self, filters: Filters) -> Floats:
        """Return the signals for the next lap."""
        return filters.following(self.table, self.error, self.gain[..., None])


def rms_of(error: Floats) -> Floats:
    """Return the root mean square over the last axis."""
    return np.sqrt(np.mean(error**2, axis=-1))


def filters(design: Any, scenario: Scenario) -> Filters:
    """Return the filters of a design's loop, from its simulated responses in the scenario's motion.

    Raises:
        UserError: design and scenario do not fit, or the loop of an axis does not answer.
    """
    axes, steps = scenario.machine.axes, scenario.simulation.steps
    length = 1 << (2 * steps - 1).bit_length()
    hertz = np.fft.rfftfreq(length, scenario.simulation.sample_time_s)
    each, limits = [], []
    for name in axes:
        some = Setup.of(design, scenario, name, None, SUITS, seed=SUIT_SEED)
        each.append(_filters(some, hertz))
        limits.append(some.largest)
    keep, correct, until = zip(*each, strict=True)
    return Filters(np.array(keep), np.array(correct), np.array(limits)[:, None], until, length)


def _filters(setup: Setup, hertz: Any) -> tuple[Floats, Any, float]:
    """Return Q and Q / (1 + SLOW) / G of an axis at ``hertz``, and up to where it learns [Hz]."""
    each = responses(setup, (), FREQUENCIES)
    with np.errstate(all="ignore"):  # where nothing answers
        every = np.concatenate([one.drive / (1.0 + one.loop) for one in each])
    usual = np.median(every.real, axis=0) + 1j * np.median(every.imag, axis=0)
    answered = np.isfinite(usual) & (usual != 0.0)
    if answered.sum() < 2:
        raise UserError(f"{setup.name}: its position does not answer to its command")
    every, usual, known = every[:, answered], usual[answered], each[0].hertz[answered]
    size, phase = np.abs(usual), np.unwrap(np.angle(usual))
    with np.errstate(all="ignore"):  # of machines that are unstable
        left = np.nan_to_num(np.abs(1.0 + SLOW - every / usual), nan=np.inf)
    unlike = np.quantile(left, MOST, axis=0) / (1.0 + SLOW) / SHRINKS
    # Towards 0 Hz the answer is that of as many derivatives as its slope shows.
    rises = np.clip(np.round(np.log(size[1] / size[0]) / np.log(known[1] / known[0])), 0.0, 2.0)
    share = 2.0 ** -np.arange(6.0, 0.0, -1.0)
    low = np.arange(len(share))
    size = np.insert(size, 0 * low, size[0] * share**rises)
    phase = np.insert(phase, 0 * low, 0.5 * np.pi * rises * (1.0 - share) + phase[0] * share)
    unlike = np.insert(unlike, 0 * low, unlike[0])
    known = np.log(np.insert(known, 0 * low, known[0] * share))
    least = (LEAST * size.max() / size) ** 2 / (1.0 + SLOW)
    at = np.log(np.maximum(hertz, np.exp(known[0])))
    kept = np.interp(at, known, 1.0 / np.maximum(1.0 + least, unlike), right=0.0)
    answer = np.exp(np.interp(at, known, np.log(size)) + 1j * np.interp(at, known, phase))
    learns = np.flatnonzero(kept >= LEARNS)
    until = float(hertz[learns[-1]]) if len(learns) else 0.0
    return kept, kept / (1.0 + SLOW) / answer, until


class Learned(NamedTuple):
    """What laps showed, the nominal machine first; nan: the machine diverges.

    The rows are a lap without a table, those that learn, and one with the table that is kept.
    """

    rms: Floats  # (rows, machines) of the error of all axes
    largest: Floats  # (rows, machines) largest contour error, or of one axis the largest error
    shared: Floats  # (machines,) the same, all with the table of the nominal machine
    table: Floats  # (axes, steps) that the nominal machine keeps
    errors: tuple[Floats, Floats]  # (axes, steps) of the nominal machine in the first and last row


def learned(setup: Setup, filters: Filters, laps: int, progress: Progress | None = None) -> Learned:
    """Return what each machine learns from its own laps.

    The noise of the encoders is another in each lap. ``progress`` is called with the numbers of
    finished and of all machines.
    """
    shape = len(setup.loop.limits), setup.scenario.simulation.steps
    rms, largest, shared, nominal = [], [], [], None
    count = setup.machines.size
    width = -(-count // -(-count // AT_ONCE))  # chunks of one size share a program
    for begin in range(0, count, width):
        machines = setup.machines.take(np.minimum(np.arange(begin, begin + width), count - 1))
        table, kept, rows = np.zeros((machines.size, *shape)), None, []
        for number in range(laps + 2):
            lap = _lap(setup, machines, table, number)
            rows.append(lap)
            kept = kept.after(table, lap.error) if kept else Kept.of(table, lap.error)
            table = kept.following(filters) if number < laps else kept.table
        rms.append([rms_of(lap.error.reshape(machines.size, -1)) for lap in rows])
        largest.append([lap.largest for lap in rows])
        nominal = nominal or (table[0], (rows[0].error[0], rows[-1].error[0]))
        shared.append(_lap(setup, machines, nominal[0], laps + 1).largest)
        if progress:
            progress(min(begin + width, count), count)
    assert nominal is not None
    rows_of_all = (np.concatenate(x, axis=-1)[..., :count] for x in (rms, largest, shared))
    errors, most, with_one_table = rows_of_all
    return Learned(errors, most, with_one_table, *nominal)


class _Lap(NamedTuple):
    error: Floats  # (machines, axes, steps) as the encoders show it
    largest: Floats  # (machines,)


def _lap(setup: Setup, machines: Machines, table: Floats, number: int) -> _Lap:
    """Return a lap with a table (machines, axes, steps), or one (axes, steps) for all."""
    sensors, axes = setup.scenario.sensors, setup.scenario.machine.axes
    motion = load_scenario(setup.scenario, {"sensors.seed": sensors.seed + number})
    samples, every = motion.samples(), tuple(range(len(axes)))
    signals = moved(setup, machines, samples, table, [None] * len(axes), every)
    target = np.array([np.asarray(one.target) for one in samples.axes])
    error = target - _read(motion, samples, signals)
    return _Lap(error, largest_error(samples, signals.place - target))


def _read(motion: Scenario, samples: Samples, signals: Moved) -> Floats:
    """Return the fed back positions with the noise and steps of their encoders."""
    read = []
    for k, drive in enumerate(motion.machine.drives):
        angle = [*drive.encoders].index(drive.seen[0]) if drive.seen[0] in drive.encoders else 0
        place = signals.seen[:, k] + np.asarray(samples.axes[k].noise)[angle]
        step = motion.sensors.of(motion.machine.axes[k]).encoder_resolution
        read.append(step * np.floor(place / step + 0.5) if step else place)
    return np.stack(read, axis=1)


def largest_error(samples: Samples, off: Floats) -> Floats:
    """Return the largest contour error of positions ``off`` (machines, axes, steps) their targets.

    It is ``estimated_max_contour_error``; of a machine that follows no path the largest error.
    """
    errors = off if samples.path is None else off_path(samples.path, [*np.moveaxis(off, 1, 0)])[0]
    return np.abs(errors).reshape(len(off), -1).max(axis=1)
