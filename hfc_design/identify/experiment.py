"""An experiment that tells most of a machine's parameters, inside the limits of every machine.

The experiment is a row of segments, each from rest to rest in the middle of the travel: moves to
and fro at several speeds, sines and sweeps of the reference, and, if a signal may be added to the
command, binary noise, sweeps and stepped sines there. All candidates are simulated on some machines
within the tolerances, and made smaller until none exceeds a limit. The one that adds most Fisher
information on the wanted parameters is taken next (Ljung, System Identification, 1999, sec. 13.3),
until the time is used up.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.controllers.gains.genome import GainVectors
from hfc_design.core.numbers import Floats, Integers, Json
from hfc_design.core.records import UserError, option
from hfc_design.files.design import Design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.fit import VAGUE, Problem, slopes
from hfc_design.identify.identifiability import NEARLY, TOGETHER
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import replay
from hfc_design.identify.segments import Limits, Segment, segments
from hfc_design.runs.individuals import design_of, genome_of
from hfc_design.simulation.following import followed
from hfc_design.simulation.frequency import Setup
from hfc_design.simulation.sensors import largest_command
from plants.around import plain

#: Number of segments; of machines on which they are compared, on which candidates are tried, and
#: on which the limits of the experiment are checked.
SEGMENTS, COMPARED, TRIED, CHECKED = 8, 4, 125, 1000
#: Share of each limit that candidates use by design; share that machines may use of travel, speed,
#: acceleration (of the reference alone) and command (which is limited in any case); factor by which
#: a segment is made smaller at least, and at most, until none uses more, and how often.
USED, ALLOWED, SMALLER, HALF, TRIES = 0.85, (0.95, 0.95, 1.0, 1.0), 0.97, 0.5, 20
SHORT = "is too short for any experiment"
#: An experiment must tell at least one parameter with a smaller relative standard error than this.
TELLS = 0.5
#: Bandwidth of the observer in the replay of a log [Hz], at most this share of the sampling rate.
OBSERVER, SHARE = 20.0, 0.1
#: Time in which a speed without an acceleration is reached [s].
SOON = 0.1
#: Share of the machines whose speed in the scenario's motion is the limit.
MOST = 0.95
#: Number of segments that are kept for signals on the command.
KEPT = 2
#: Number of times that a candidate may be taken.
REPEATED = 3
#: Most rounds of exchanges.
ROUNDS = 10
#: Noise of a machine without noise or encoder steps, as a share of the travel.
NOTHING = 1e-7
#: Bandwidth of the loop that follows the reference, as a share of the largest stable one.
CALM = 0.2
#: Least travel in steps of the encoder.
LEAST = 100.0


class Experiment(NamedTuple):
    """A whole experiment, and what it is expected to show."""

    segments: tuple[Segment, ...]
    sample_time: float  # [s]
    limits: Limits
    reached: dict[str, float]  # largest share of each limit on any machine
    machines: int  # on which the limits were checked
    errors: dict[str, tuple[float, float]]  # relative standard error: scenario's motion, experiment
    held: tuple[str, ...]  # parameters that no experiment can tell from others; they must be known
    units: Mapping[str, str]

    def numbers(self) -> Json:
        """Return the output of ``hfc experiment --json``, without the samples."""
        return {
            "duration": self.duration,
            "sample_time": self.sample_time,
            "segments": [one.told(self.units) for one in self.segments],
            "limits": self.limits._asdict(),
            "used": self.reached,
            "machines": self.machines,
            "errors": {x: {"motion": a, "experiment": b} for x, (a, b) in self.errors.items()},
            "held": [*self.held],
        }

    @property
    def time(self) -> Floats:
        """Time (steps,) of each sample [s]."""
        return np.asarray(self.sample_time * np.arange(len(self.reference)))

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.sample_time * len(self.reference)

    @property
    def reference(self) -> Floats:
        """Reference (steps,) from the middle of the travel."""
        return np.concatenate([one.reference for one in self.segments])

    @property
    def added(self) -> Floats:
        """Signal (steps,) that is added to the command."""
        return np.concatenate([one.added for one in self.segments])


def choose(
    setup: Setup,
    duration: float,
    given: Mapping[str, float],
    names: Sequence[str] | None,
    add: bool,
) -> Experiment:
    """Return the experiment for an axis, see ``calls.identifying.experiment``.

    ``setup`` is the loop that follows the reference, at rest, with at least ``CHECKED`` machines;
    ``given`` has limits instead of the default ones.

    Raises:
        UserError: a parameter is unknown, or the travel is too short for any experiment.
    """
    scenario, every, one = setup.scenario, setup.every, setup.scenario.plant.each()[setup.axis]
    drive, sensors = scenario.machine.drives[setup.axis], scenario.sensors.of(one.name)
    step = max(one.resolution or 0.0, sensors.encoder_resolution)
    noise = np.hypot(step / np.sqrt(12.0), sensors.noise)
    steps, few, every_one = int(duration / every / SEGMENTS), *map(np.arange, (TRIED, CHECKED))
    reference_run = _simulated(setup, _own_motion(setup, SEGMENTS * steps), few)
    own = _default_limits(setup, reference_run)
    if (most := given.get("command", 0.0)) > own.command:
        raise UserError(f"{option('command', most)}: must be at most {own.command:g}, its limit")
    limits = own._replace(**given)
    if limits.travel < LEAST * step:
        least = f"must be at least {LEAST * step:.3g} {drive.units['error']}, {LEAST:g} steps"
        raise UserError(f"{option('travel', limits.travel)}: {least} of the encoder")
    inner = Limits(*(USED * x for x in limits))
    candidates = [*segments(inner, every, steps, add)]
    runs = [run for one in candidates if (run := _inside(setup, one, limits, few))]
    if not runs:
        raise UserError(f"{option('travel', limits.travel)}: {SHORT}")
    noise = noise or NOTHING * limits.travel
    wanted, before = _information(setup, reference_run, noise, names)
    tables = np.array([_information(setup, run, noise, names)[1] for run in runs])
    determined = _determined(tables.sum(axis=(0, 1)), len(wanted))
    before, tables = (x[..., determined, :][..., determined] for x in (before, tables))
    free = [wanted[k] for k in determined if k < len(wanted)]
    if not free:
        raise UserError(f"{option('travel', limits.travel)}: {SHORT}")
    chosen = _best(tables, len(free), [bool(run.segment.added.any()) for run in runs])
    picked = {k: _inside(setup, runs[k].segment, limits, every_one) for k in set(chosen)}
    made = [run for k in sorted(chosen) if (run := picked[k])]
    if not made:
        raise UserError(f"{option('travel', limits.travel)}: {SHORT}")
    after = np.sum([_information(setup, run, noise, names)[1] for run in made], axis=0)
    after = after[..., determined, :][..., determined]
    pairs = zip(free, _errors(before).mean(axis=0), _errors(after).mean(axis=0), strict=False)
    expected = {name: (float(one), float(two)) for name, one, two in pairs}
    if not min(two for _, two in expected.values()) < TELLS:
        raise UserError(f"{option('travel', limits.travel)}: {SHORT}")
    reached = np.max([_reached(run, limits, every).max(axis=1) for run in made], axis=0)
    shares = dict(zip(Limits._fields, reached.tolist(), strict=True))
    unknown = tuple(name for name in wanted if name not in expected)
    parts, count = tuple(run.segment for run in made), setup.machines.size
    return Experiment(parts, every, limits, shares, count, expected, unknown, drive.units)


def _own_motion(setup: Setup, steps: int) -> Segment:
    """Return the scenario's first motion, to and fro for so many steps."""
    reference = np.asarray(setup.scenario.each_motion()[0].samples().axes[setup.axis].reference)
    both = np.append(reference, reference[::-1]) - reference[0]
    return Segment("the scenario's motion", np.resize(both, steps), np.zeros(steps))


class _Run(NamedTuple):
    """A simulated segment, arrays (steps, machines)."""

    segment: Segment
    command: Floats
    place: Floats  # that is fed back


def _simulated(setup: Setup, one: Segment, chosen: Integers) -> _Run:
    """Return a segment on the chosen machines."""
    return _Run(one, *followed(setup, setup.machines.take(chosen), one.reference, one.added))


def _reached(run: _Run, limits: Limits, every: float) -> Floats:
    """Return the largest share of each limit on each machine, (4, machines)."""
    place = run.place - run.place[0]
    with np.errstate(all="ignore"):
        speed = np.abs(np.diff(place, axis=0)).max(axis=0) / every
        faster = np.abs(np.diff(run.segment.reference, 2)).max() / every**2 + 0.0 * speed
        ends = 2.0 * np.abs(place).max(axis=0), speed, faster, np.abs(run.command).max(axis=0)
    shares = np.array([x / most for x, most in zip(ends, limits, strict=True)])
    return np.where(np.isfinite(shares), shares, np.inf)


def _inside(setup: Setup, one: Segment, limits: Limits, chosen: Integers) -> _Run | None:
    """Return a segment, reduced until chosen machines have a margin to limits; None: impossible."""
    size = 1.0
    for _ in range(TRIES):
        moves = tuple((size * place, size * speed) for place, speed in one.moves)
        less = Segment(one.words, size * one.reference, size * one.added, moves)
        run = _simulated(setup, less, chosen)
        worst = (_reached(run, limits, setup.every).max(axis=1) / ALLOWED).max()
        if worst <= 1.0:
            return run
        size *= float(np.clip(1.0 / worst, HALF, SMALLER))  # a half where a machine diverges
    return None


def _information(
    setup: Setup, run: _Run, noise: float, names: Sequence[str] | None
) -> tuple[tuple[str, ...], Floats]:
    """Return the wanted names, and (machines, numbers, numbers) information on them and LATE."""
    drive, every = setup.scenario.machine.drives[setup.axis], setup.every
    tables = []
    for k in range(COMPARED):
        values = jax.tree.map(lambda leaf, k=k: float(leaf[k]), setup.machines.actual[setup.axis])
        free = free_parameters(drive, plain(values)._asdict(), names)
        still = np.zeros(len(run.command))
        seen, counts = {drive.seen[0]: run.place[:, k]}, still + 1.0
        log = Recording(seen, run.command[:, k], None, still, still, counts, every, 0.0)
        observer = min(OBSERVER, SHARE / every)
        residual = replay(free, log, observer, setup.scenario.simulation.substeps)
        problem = Problem(free, residual, np.ones(1), np.ones(len(free.begun)), observer)
        rows = np.nan_to_num(slopes(problem, free.begun)[1][:, 0] / noise)
        tables.append(rows.T @ rows)
    return free.names, np.array(tables)


def _best(tables: Floats, count: int, added: Sequence[bool]) -> list[int]:
    """Return the segments with least mean logarithm of the errors of the first ``count`` numbers.

    They are exchanged one by one until none is better (Fedorov, Theory of Optimal Experiments,
    1972, ch. 3). The last ``KEPT`` have an added signal, if there are such.
    """
    every = [*range(len(tables))]
    extra = [k for k in every if added[k]] or every
    chosen, least = list[int](), np.inf
    for _ in range(ROUNDS):
        before = chosen.copy()
        for place in range(SEGMENTS):
            others = chosen[:place] + chosen[place + 1 :]
            most = max(REPEATED, -(-SEGMENTS // len(tables)))  # for variety: the model may be wrong
            some = extra if place >= SEGMENTS - KEPT else every
            some = [k for k in some if others.count(k) < most]
            sums = tables[others].sum(axis=0)
            worth = [np.log(_errors(sums + tables[k])[:, :count]).mean() for k in some]
            if len(chosen) <= place or min(worth) < least:
                chosen[place : place + 1], least = [some[int(np.argmin(worth))]], min(worth)
        if chosen == before:
            break
    return chosen


def _determined(information: Floats, count: int) -> list[int]:
    """Return the numbers that some experiment determines, if the others are known.

    Of the first ``count`` numbers that only change together, the last one is held, as in
    ``identifiability``.
    """
    left = [*range(len(information))]
    while len(left) > 1:
        some = information[np.ix_(left, left)] + VAGUE**-2 * np.eye(len(left))
        sizes, ways = np.linalg.eigh(some)
        if sizes[0] ** -0.5 * np.abs(ways[:, 0]).max() < TOGETHER:
            break
        part = np.abs(ways[:, 0])
        near = [k for k, x in zip(left, part, strict=True) if x >= NEARLY * part.max()]
        left.remove(max([k for k in near if k < count], default=near[-1]))
    return left


def _errors(information: Floats) -> Floats:
    """Return the standard error of each number, (machines, numbers)."""
    prior = VAGUE**-2 * np.eye(information.shape[-1])
    return np.sqrt(np.diagonal(np.linalg.inv(information + prior), axis1=-2, axis2=-1))


def _default_limits(setup: Setup, run: _Run) -> Limits:
    """Return limits within which a scenario's motions are, and the largest command.

    The speed is what machines reach in a motion, ``run``, which may be far more than that of the
    reference. Without a limit of its own the acceleration is at least that for this in ``SOON``.
    """
    scenario, axis = setup.scenario, setup.axis
    each, one = scenario.each_motion(), scenario.plant.each()[axis]
    axes = [motion.samples().axes[axis] for motion in each]
    travel = max(float(np.ptp(x.reference)) for x in axes)
    with np.errstate(all="ignore"):
        speeds = np.abs(np.diff(run.place, axis=0)).max(axis=0) / setup.every
    speeds = np.where(np.isfinite(speeds), speeds, np.inf)  # it diverges
    speed = max(float(np.abs(x.reference_rate).max()) for x in axes)
    speed = max(speed, float(np.nan_to_num(np.quantile(speeds, MOST, method="lower"), posinf=0.0)))
    faster = [x.reference_acceleration for x in axes if x.reference_acceleration is not None]
    limited = [getattr(motion.reference, "acceleration", None) or 0.0 for motion in each]
    limited += [
        (getattr(motion.path, "acceleration_mm_s2", None) or 0.0) / (one.length or 1.0)
        for motion in each
    ]
    acceleration = max([*limited, *(float(np.abs(x).max()) for x in faster)], default=0.0)
    acceleration = acceleration if any(limited) else max(acceleration, speed / SOON)
    limit = largest_command(scenario.limits.of(one.name))
    return Limits(travel, speed, acceleration, one.drive.largest_commands(one.parameters, limit)[1])


def follower(scenario: Scenario) -> Design:
    """Return a calm PID with feed-forward, for machines whose own control is not known."""
    settings = {"controller": {"kind": "pid+ff"}}
    where = load_scenario(scenario.model_dump(exclude_unset=True) | settings)
    genome: Any = genome_of(where)
    calm, places = genome.designed(np.array([CALM * genome.bandwidths[0]])), genome.empty().places
    for k, (name, one) in enumerate(genome.searched.items()):
        if name in calm:
            places[:, k] = one.place(calm[name])
    return design_of(GainVectors(np.zeros(1, int), places), where)
