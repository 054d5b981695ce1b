"""Whether a machine does what its design promised: a log against machines within the tolerances.

The reference of the log is followed by a thousand simulated machines. What is compared are error
and command in stretches of the log: their means, and the roughness of both (chatter). A log is
unlike the machines if its distance from their mean (Mahalanobis, with the covariance of Ledoit and
Wolf, J. Multivariate Analysis 88, 2004) is larger than those of machines that did not make this
covariance: their ranks give the p-value, whatever the distribution. For each parameter, nominal
machines with other values show how the log would change; the one that explains it best is named.
"""

from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

import jax
import numpy as np
from matplotlib.figure import Figure

from hfc_design.core.numbers import Floats, Json, storable
from hfc_design.core.records import UserError, option
from hfc_design.core.tables import Table
from hfc_design.core.wording import percent, three_digits
from hfc_design.files.robust import friction_of
from hfc_design.identify.recording import Recording
from hfc_design.plotting.curves import thinned
from hfc_design.plotting.figure import OTHER, OWN, above, finish, framed
from hfc_design.simulation.following import followed
from hfc_design.simulation.frequency import Setup
from hfc_design.simulation.population import Machines, standing

#: Stretches of a log; share of the machines that make the covariance.
STRETCHES, MAKING = 40, 0.5
#: Standard errors to which the deviation of a single feature is limited.
ODD = 8.0
#: A log is unlike the machines below this p-value.
UNLIKE = 0.05
#: Factors on a parameter, added delays [samples], and gaps [rms error of the log] that are tried.
FACTORS = (0.5, 0.7, 0.85, 1.0, 1.15, 1.3, 1.5, 2.0, 3.0)
DELAYS, GAPS = (0.0, 0.5, 1.0, 2.0), (0.0, 0.3, 1.0, 3.0)
#: Number of steps between two of these; explanations within this distance are as good.
BETWEEN, ALIKE = 10, 4.0
#: Largest share of the squared distance that a change may leave to explain a log.
LEFT = 0.5
#: Largest command of a log, as a multiple of the limit of the design.
BEYOND = 1.5
#: Largest difference of the references of two logs, as a share of the travel.
LIKE = 0.02
#: Longest additional delay [samples] for which the loop has room.
LATER = 2.0
FRICTION, DELAY, GAP = "friction", "delay_samples", "backlash"


class Explanation(NamedTuple):
    """A change of the nominal machine that would explain a log."""

    name: str  # of the parameter, or ``FRICTION``, ``DELAY`` or ``GAP``
    change: str  # in words
    distance: float  # squared, of the log from the machines with the change
    size: float
    keys: dict[str, float]  # of the scenario, with their values on the changed machine


class Check(NamedTuple):
    """A log against what a design promised."""

    log: str
    machines: int
    p_value: float
    measured: dict[str, float]  # numbers of the log, with units in their names
    expected: dict[str, tuple[float, float]]  # 5 and 95 % of the machines
    explanations: tuple[Explanation, ...]  # the best first; (): it is not unlike
    curves: dict[str, tuple[Floats, Floats]]  # signal with unit -> log (steps,), ends (2, steps)
    sample_time: float  # [s]
    unchanged: float = np.inf  # squared distance from the machines, before any explanation
    again: str = ""  # whether to design again
    margins: str = ""  # of the loop, from the log's own signals

    @property
    def unlike(self) -> bool:
        """Whether the machine does not do what was promised."""
        return self.p_value < UNLIKE

    @property
    def explained(self) -> bool:
        """Whether the best explanation leaves at most ``LEFT`` of the squared distance."""
        return self.unlike and self.explanations[0].distance <= LEFT * self.unchanged

    @property
    def verdict(self) -> str:
        """The answer in a sentence."""
        chance = f"p = {self.p_value:.2g}: so far off are {percent(self.p_value)} of the machines"
        if not self.unlike:
            return f"the machine does what was promised ({chance} within the tolerances)"
        best = self.explanations[0]
        if not self.explained:
            lacks = (
                f"no single change explains it (best: {best.change}), so the model lacks something"
            )
            return f"the machine does NOT do what was promised ({chance}): {lacks}"
        near = [x.name for x in self.explanations[1:] if x.distance < best.distance + ALIKE]
        other = f" (or {', '.join(near)})" if near else ""
        what = f"{best.change}{other}{self.again}"
        return f"the machine does NOT do what was promised ({chance}): {what}"

    def numbers(self) -> Json:
        """Return the output of ``hfc check --json``."""
        return {
            "log": self.log,
            "machines": self.machines,
            "p_value": self.p_value,
            "as_promised": not self.unlike,
            "verdict": self.verdict,
            "measured": storable(self.measured),
            "expected": {name: [*ends] for name, ends in self.expected.items()},
            "explanations": [storable(one._asdict()) for one in self.explanations],
        }

    def tables(self) -> list[Table]:
        """Return the table of the numbers with the band of the machines, and explanations."""
        rows = []
        for name, value in self.measured.items():
            low, high = self.expected[name]
            inside = "yes" if low <= value <= high else "no"
            rows.append([name, three_digits(value), f"{low:.3g}..{high:.3g}", inside])
        about = f"{self.log} and 5 to 95 % of {self.machines} machines within the tolerances."
        lines = [x for x in (self.verdict, self.margins) if x]
        tables = [Table(about, ("number", "log", "machines", "inside"), rows, lines=lines)]
        if self.unlike:
            rows = [[x.name, x.change, f"{x.distance:.3g}"] for x in self.explanations[:5]]
            why = "Changes that would explain it, the best first; the distance is squared."
            tables.append(Table(why, ("changed", "how", "distance"), rows))
        return tables

    def figure(self) -> Figure:
        """Draw error and command of the log, with the band of the machines."""
        figure = framed(4.4, top=0.35)
        panels = figure.subplots(len(self.curves), sharex=True)
        for axes, (label, (values, ends)) in zip(panels, self.curves.items(), strict=True):
            time = np.asarray(self.sample_time * np.arange(len(values)), float)
            axes.fill_between(time, *ends, color=OTHER, alpha=0.3, lw=0, label="5 to 95 %")
            axes.plot(*thinned(time, values), color=OWN, lw=0.9, label="log")
            finish(axes, label, "time [s]" if axes is panels[-1] else "")
        above(figure, panels[0])
        return figure


class Promise:
    """What machines do that follow the reference of a log; other logs of it can be checked too.

    ``setup`` has the nominal machine first.

    Raises:
        UserError: the log (``name``) has no reference or no command.
    """

    def __init__(self, setup: Setup, log: Recording, name: str):
        if log.reference is None or log.command is None:
            missing = "reference" if log.reference is None else "command"
            needs = "a check needs reference, position and command"
            raise UserError(f"{name}: has no {missing}; {needs}")
        _check_units(setup, log, name)
        self._setup, self._reference, self._added = setup, log.reference, log.added
        drive, sensors = setup.scenario.machine.drives[setup.axis], setup.scenario.sensors
        self._noise = sensors.of(setup.scenario.machine.axes[setup.axis]).noise
        self._units, self._error = drive.units, float(np.std(log.reference - log.place))
        command, place = self._followed(setup.machines)
        drawn = self._features(command, place)[:, 1:]
        made = int(MAKING * drawn.shape[1])
        self._usual = _Usual.of(drawn[:, :made])
        self._ranks = self._usual.distance(drawn[:, made:] - self._usual.mean[:, None])
        each = self._numbers(command[:, 1:], place[:, 1:]).items()
        error = self._reference[:, None] - place[:, 1:]
        self._bands = [np.quantile(x, (0.05, 0.95), axis=1) for x in (error, command[:, 1:])]
        quantiles = {name: np.quantile(x, (0.05, 0.95)).tolist() for name, x in each}
        self._expected = {name: (low, high) for name, (low, high) in quantiles.items()}

    def check(self, log: Recording, name: str, first: Recording | None = None) -> Check:
        """Return how a log with this reference compares with the machines.

        ``first`` is a log of the same machine and reference when it was in order: then only what
        has changed since counts, and not what the model lacks.

        Raises:
            UserError: the two logs have different references.
        """
        signals, expected = self._signals(log), self._expected
        off = self._features(*signals) - self._usual.mean[:, None]
        if first is not None:
            self._check_same(first)
            before = self._signals(first)
            off = self._features(*signals) - self._features(*before)
            numbers, ends = self._numbers(*before), expected
            expected = {}
            for key, (low, high) in ends.items():
                shift = float(numbers[key][0]) - 0.5 * (low + high)
                expected[key] = (low + shift, high + shift)
        count, distance = len(self._ranks), self._usual.distance(off)
        # The difference of two logs varies as both do.
        alike = distance if first is None else 0.5 * distance
        p_value = float((1.0 + np.sum(self._ranks >= alike)) / (1.0 + count))
        values = {key: float(x[0]) for key, x in self._numbers(*signals).items()}
        explained = tuple(self._explained(off)) if p_value < UNLIKE else ()
        machines = self._setup.machines.size - 1
        labels = f"error [{self._units['error']}]", f"command [{self._units['command']}]"
        drawn = self._reference - signals[1][:, 0], signals[0][:, 0]
        curves = dict(zip(labels, zip(drawn, self._bands, strict=True), strict=True))
        known = (values, expected, explained, curves, self._setup.every, float(distance[0]))
        return Check(name, machines, p_value, *known)

    def _signals(self, log: Recording) -> tuple[Floats, Floats]:
        """Return command and position (steps, 1) of a log."""
        assert log.command is not None
        count = len(self._reference)
        return log.command[:count, None], log.place[:count, None]

    def _check_same(self, first: Recording) -> None:
        """Check that a log has the reference of the other one; UserError: it has not."""
        count = len(self._reference)
        reference, same = first.reference, False
        if reference is not None and first.command is not None and len(reference) >= count:
            off = np.abs(reference[:count] - self._reference).max()
            same = bool(off <= LIKE * np.ptp(self._reference))
        if not same:
            given = option("before", ...)
            raise UserError(
                f"{given}: must be a log with command and the same reference, not shorter"
            )

    def _followed(self, machines: Machines, common: bool = False) -> tuple[Floats, Floats]:
        """Return commands and positions (steps, machines) of machines that follow the reference."""
        begin = self._reference[0]
        moving = self._reference - begin, self._added, self._noise, machines.size, common
        command, place = followed(self._setup, machines, *moving)
        return command, place + begin

    def _features(self, command: Floats, place: Floats) -> Floats:
        """Return means and roughness of error and command in each stretch, (features, n)."""
        features = []
        for values in (self._reference[:, None] - place, command):
            parts = np.array_split(values, STRETCHES)
            features += [part.mean(axis=0) for part in parts]
            bends = (np.diff(part, axis=0).std(axis=0) for part in parts)
            features += [np.log(bend + 1e-12) for bend in bends]
        return np.array(features)

    def _numbers(self, command: Floats, place: Floats) -> dict[str, Floats]:
        """Return what a user knows a loop by, (n,) each, with units in the names."""
        error, unit = self._reference[:, None] - place, self._units["error"]
        return {
            f"rms error [{unit}]": np.sqrt(np.mean(error**2, axis=0)),
            f"largest error [{unit}]": np.abs(error).max(axis=0),
            f"rms command [{self._units['command']}]": np.sqrt(np.mean(command**2, axis=0)),
            f"chatter [{self._units['command']}]": np.sqrt(
                np.mean(np.diff(command, axis=0) ** 2, axis=0)
            ),
        }

    @cached_property
    def _curves(self) -> list[tuple["_Change", Floats]]:
        """Changes, and how each changes the features (features, sizes)."""
        changes = [*_factors(self._setup), *_around(self._setup, self._error)]
        true = [one.machines.actual for one in changes]
        whole = jax.tree.map(lambda *x: np.concatenate(x), *true)
        every = Machines(self._setup.machines.nominal, whole)
        ends = np.cumsum([len(one.sizes) for one in changes])[:-1]
        parts = np.split(self._features(*self._followed(every, common=True)), ends, axis=1)
        pairs = zip(changes, parts, strict=True)
        return [(one, part - part[:, one.sizes == one.none]) for one, part in pairs]

    def _explained(self, off: Floats) -> list[Explanation]:
        """Return what would explain features ``off`` the mean, the best first."""
        explanations = []
        for one, curve in self._curves:
            place = np.linspace(0.0, len(one.sizes) - 1.0, BETWEEN * (len(one.sizes) - 1) + 1)
            low = np.minimum(place.astype(int), len(one.sizes) - 2)
            share = place - low
            left = off - curve[:, low] * (1.0 - share) - curve[:, low + 1] * share
            distance = self._usual.distance(left)
            k = int(np.argmin(distance))
            size = float(one.sizes[low[k]] * (1.0 - share[k]) + one.sizes[low[k] + 1] * share[k])
            words = one.words.format(three_digits(size))
            keys = {key: x * size if one.none else x + size for key, x in one.keys.items()}
            explanations.append(Explanation(one.name, words, float(distance[k]), size, keys))
        return sorted(explanations, key=lambda one: one.distance)


def _check_units(setup: Setup, log: Recording, name: str) -> None:
    """Check that the signals of a log can be in their units; UserError: they cannot."""
    assert log.reference is not None
    assert log.command is not None
    units = setup.scenario.machine.drives[setup.axis].units
    travel, error = float(np.ptp(log.reference)), float(np.std(log.reference - log.place))
    if error > travel:
        unit = units["error"]
        got = f"(its error is {three_digits(error)} {unit}, the travel {three_digits(travel)})"
        raise UserError(
            f"{name}: the position must follow the reference; are both in their units? {got}"
        )
    limit, most = setup.largest, float(np.abs(log.command).max())
    if most > BEYOND * limit:
        got = f"(got up to {three_digits(most)})"
        raise UserError(
            f"{name}: the command must be within {three_digits(limit)} {units['command']} {got}"
        )


class _Usual(NamedTuple):
    """What is usual among machines: of their features mean, size, and inverse correlation."""

    mean: Floats  # (features,)
    size: Floats  # (features,)
    inverse: Floats  # (features, features)

    @classmethod
    def of(cls, features: Floats) -> "_Usual":
        """Return it from features (features, machines), the covariance by Ledoit and Wolf."""
        count, machines = features.shape
        mean = np.median(features, axis=1)
        off = features - mean[:, None]
        size = off.std(axis=1) + 1e-12 * (np.abs(mean) + 1e-300)
        unit = _soft(off / size[:, None])
        sample = unit @ unit.T / machines
        level = np.trace(sample) / count
        apart = np.sum((sample - level * np.eye(count)) ** 2)
        noise = (np.sum(np.sum(unit**2, axis=0) ** 2) / machines - np.sum(sample**2)) / machines
        share = float(np.clip(noise / max(apart, 1e-300), 1e-6, 1.0))
        whole = share * level * np.eye(count) + (1.0 - share) * sample
        return cls(mean, size, np.linalg.inv(whole))

    def distance(self, off: Floats) -> Floats:
        """Return squared distances (n,) of features (features, n) less the mean."""
        unit = _soft(off / self.size[:, None])
        return np.asarray(np.einsum("ij,ik,kj->j", unit, self.inverse, unit))


def _soft(unit: Floats) -> Floats:
    """Return deviations in standard errors, limited: else one odd stretch would hide the others."""
    return np.asarray(unit / np.sqrt(1.0 + (unit / ODD) ** 2))


class _Change(NamedTuple):
    """Sizes of one change, in rising order, and nominal machines with it."""

    name: str
    words: str  # with {} for a size
    keys: dict[str, float]  # of the scenario -> its value
    sizes: Floats
    none: float  # the size without a change
    machines: Machines


def _factors(setup: Setup) -> Iterator[_Change]:
    """Yield each parameter times ``FACTORS``, as far as such machines exist; friction together."""
    axis, drive = setup.axis, setup.scenario.machine.drives[setup.axis]
    values, rubs = setup.scenario.plant.values()[axis], friction_of(drive)
    groups, several = {FRICTION: rubs} if rubs else {}, _table(setup)
    others = [x for x in values._fields if x not in (*rubs, *drive.exact)]
    groups |= {x: [x] for x in others if getattr(values, x)}
    for name, parameters in groups.items():
        changed = [
            values._replace(**{x: factor * getattr(values, x) for x in parameters})
            for factor in FACTORS
        ]
        good = [k for k, x in enumerate(changed) if drive.fault(x._asdict()) is None]
        some = setup.bare.take(np.zeros(len(good), int))
        changed_values = jax.tree.map(lambda *x: np.array(x, float), *(changed[k] for k in good))
        true = tuple(changed_values if k == axis else x for k, x in enumerate(some.actual))
        machines = standing(Machines(some.nominal, true), setup.scenario, setup.loop)
        keys = {f"plant{several or '.parameters'}.{x}": getattr(values, x) for x in parameters}
        words = f"{name} times {{}}"
        yield _Change(name, words, keys, np.array(FACTORS)[good], 1.0, machines)


def _table(setup: Setup) -> str:
    """Return where a table of the scenario has the keys of the axis, if there are several."""
    axes = setup.scenario.machine.axes
    return f".axes.{axes[setup.axis]}" if len(axes) > 1 else ""


def _around(setup: Setup, error: float) -> Iterator[_Change]:
    """Yield longer delays of the command, and gaps before the encoder, unless the drive has one."""
    drive = setup.scenario.machine.drives[setup.axis]
    each = {DELAY: (np.array(DELAYS), "{} samples of delay more")}
    if not getattr(setup.scenario.plant.values()[setup.axis], GAP, 0.0):
        each[GAP] = error * np.array(GAPS), f"{{}} {drive.units['error']} of backlash more"
    for name, (sizes, words) in each.items():
        some = setup.bare.take(np.zeros(len(sizes), int))
        more = np.zeros((len(setup.loop.limits), len(sizes)))
        more[setup.axis] = sizes
        machines = standing(some, setup.scenario, setup.loop, {name: more})
        now = setup.scenario.limits.of(setup.scenario.machine.axes[setup.axis]).delay_samples
        keys = {f"limits{_table(setup)}.{DELAY}": now} if name == DELAY else {}
        yield _Change(name, words, keys, sizes, 0.0, machines)
