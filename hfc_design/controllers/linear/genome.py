"""Genomes of the linear kinds: gains, or weights from which optimal gains follow.

Every searched number has a range, so that every strategy can search it. The ranges follow from the
nominal drive. Feed-forward gains are searched as multiples of what the nominal drive needs.
"""

from abc import abstractmethod

import numpy as np

from hfc_design.controllers.gains.genome import GainsGenome, GainVectors, Searched
from hfc_design.controllers.genome import Genome
from hfc_design.controllers.kind import Target
from hfc_design.controllers.linear import record, regulator
from hfc_design.controllers.linear.law import LinearGains
from hfc_design.controllers.linear.record import FORWARD, LEAD, MULTIPLES, LinearSettings
from hfc_design.controllers.linear.regulator import BEHIND
from hfc_design.core.numbers import Floats, Integers, Json
from hfc_design.core.records import UserError
from hfc_design.stability.nominal import nominal

#: Share of first individuals anywhere in the ranges; the others are around good ones.
ANYWHERE = 0.25
#: Smallest and largest distance of individuals around good ones, in shares of the ranges.
AROUND = (0.003, 0.1)
#: Largest multiple of the feed-forward that the nominal drive needs.
MOST_OF_NOMINAL = 2.0
#: Form of a control that takes the gains as parameters -> searched numbers that are 0 in it.
ABSENT: dict[str | None, tuple[str, ...]] = {None: (), "pid": ("derivative_hz",)}
ABSENT["cascade"] = ("derivative_hz", "velocity_multiple", "coulomb_multiple")
#: Range and first value of the numbers of filters, frequencies as shares of the sampling rate; if
#: modes are known, a notch is searched from half the lowest to twice the highest of them.
FILTERED = {"notch_hz": (0.01, 0.45, 0.1), "lowpass_hz": (0.02, 0.45, 0.3)}
FILTERED |= {"notch_width": (0.1, 2.0, 0.5), "notch_depth": (0.01, 1.0, 0.5)}
#: Width of the smoothed sign of the speed, in shares of the speed at which the drive slides:
#: narrowest, start of a search, widest.
WIDTH = (0.001, 0.01, 0.1)


class LinearGenome(GainsGenome):
    """Base of the linear genomes; ``GainVectors.places`` has the order of ``searched``.

    Raises:
        UserError: the drive of the first axis, which represents all, cannot be linearised.
    """

    def __init__(self, settings: LinearSettings, target: Target):
        Genome.__init__(self, settings, target)
        self.drive, self.every = target.machine.drives[0], target.sample_time
        self.model = nominal(self.drive, target.parameters[0], self.every, settings.speed)
        self._prepare()
        low, high = (share / self.every for share in regulator.BANDWIDTHS)
        #: Bandwidth [1/s] at the start of a search, and the largest.
        self.bandwidths = regulator.bandwidth(self.model, self.every), high
        three = (low, high, self.bandwidths[0])
        searched = self._searched(*(self._one(speed) for speed in three))
        multiples = FORWARD if settings.expected_load else FORWARD[:-1]
        searched |= dict.fromkeys(multiples, Searched(0.0, MOST_OF_NOMINAL, 1.0))
        if settings.coulomb_width is None:
            low, wide, high = (share * self.model.speed for share in WIDTH)
            searched["coulomb_width"] = Searched(low, high, wide)
        for name in settings.filters:
            low, high, one = (x / self.every if "hz" in name else x for x in FILTERED[name])
            if modes := [hz for hz in target.modes if name == "notch_hz" and hz < high]:
                low, high, one = 0.5 * min(modes), min(2.0 * max(modes), high), modes[0]
            searched[name] = Searched(low, high, one)
        absent = ABSENT[getattr(settings, "control", None)]
        for name, (low, high) in (dict.fromkeys(absent, (0.0, 0.0)) | settings.ranges).items():
            if name not in searched:
                raise UserError(f"controller.ranges.{name}: is not searched here")
            if name in settings.filters and "hz" in name and high * self.every >= 0.5:
                raise UserError(f"controller.ranges.{name}: must be below half the sampling rate")
            searched[name] = Searched(low, high, float(np.clip(searched[name].start, low, high)))
        self.searched = searched
        self.ranges = tuple(searched)  # names of the searched numbers

    def _prepare(self) -> None:
        """Set further attributes that a subclass needs, from the model."""

    @abstractmethod
    def designed(self, bandwidths: Floats) -> dict[str, Floats]:
        """Return searched feedback numbers (n,) of good individuals with bandwidths (n,) [1/s]."""

    @abstractmethod
    def _searched(
        self, low: dict[str, float], high: dict[str, float], start: dict[str, float]
    ) -> dict[str, Searched]:
        """Return the range of each feedback number, from good individuals of three bandwidths."""

    @abstractmethod
    def _feedback(self, values: dict[str, Floats]) -> dict[str, Floats]:
        """Return kp, ki, kd, filter_pole, gains on signals and two of each resonator, each (n,).

        Those of a resonator have its name, the second one with the suffix ``BEHIND``.
        """

    @property
    @abstractmethod
    def signals(self) -> tuple[str, ...]:
        """Names of the signals that are fed back."""

    def empty(self) -> GainVectors:
        """Return one individual, the start of the search."""
        places = [float(one.place(one.start)) for one in self.searched.values()]
        return GainVectors(np.zeros(1, int), np.array([places]))

    def fresh(self, tree: Integers, rng: np.random.Generator) -> GainVectors:
        """Return the start, individuals around it, around good ones, and anywhere in range."""
        count = len(tree)
        slow, fast = np.log(self.bandwidths)
        good = self.designed(np.exp(rng.uniform(slow, fast, count)))
        places = np.tile(self.empty().places, (count, 1))
        for k, (name, one) in enumerate(self.searched.items()):
            if name in good:
                places[:, k] = one.place(good[name])
        near, away = np.log(AROUND)
        places += np.exp(rng.uniform(near, away, (count, 1))) * rng.standard_normal(places.shape)
        anywhere = rng.random((count, 1)) < ANYWHERE
        places = np.where(anywhere, rng.random(places.shape), np.clip(places, 0.0, 1.0))
        places[:1] = self.empty().places
        return GainVectors(tree, places)

    def _one(self, speed: float) -> dict[str, float]:
        values = self.designed(np.array([speed]))
        return {name: float(value[0]) for name, value in values.items()}

    def gains(self, population: GainVectors) -> LinearGains:
        """Return the gains of the law, each (n,)."""
        values = self.values(population)
        feedback = self._feedback(values)
        each = {name: feedback[name] for name in self.signals}
        forward = regulator.ahead(self.model, each)
        for name, multiple in zip(MULTIPLES, FORWARD, strict=True):
            forward[name] = values.get(multiple, 1.0) * forward[name]
        forward["load"] = forward["load"] * self.settings.expected_load
        numbers = {name: feedback[name] for name in ("kp", "ki", "kd", "filter_pole")} | forward
        numbers["width"] = values.get("coulomb_width", self.settings.coulomb_width)
        one = np.ones(len(population.tree))
        whole = {name: one * number for name, number in numbers.items()}
        turning = [[feedback[name], feedback[name + BEHIND]] for name in self.settings.resonators]
        return LinearGains(
            **whole,
            signals=np.array([*each.values()]) if each else None,
            resonators=np.array(turning) if turning else (),
            filters=tuple(record.filters_of(values, self.every).values()),
        )

    def record(self, individual: GainVectors) -> Json:
        """Return the record of the kind and its gains, without the sample time."""
        gains = self.gains(individual)
        keys, values = ("derivative_hz", *FILTERED), self.values(individual).items()
        arrays = {"kp": gains.kp, "kd": gains.kd} | {key: x for key, x in values if key in keys}
        numbers = {name: float(x[0]) for name, x in arrays.items()}
        return {"kind": self.settings.kind, **numbers, **self.linear_record(gains)}

    def linear_record(self, gains: LinearGains) -> Json:
        """Return further keys of a linear law from the gains of one individual."""
        forward = {name: float(getattr(gains, name)[0]) for name in MULTIPLES[:3]}
        expected = self.settings.expected_load
        if expected:
            forward |= {"load": float(gains.load[0]) / expected, "expected_load": expected}
        rows = () if gains.signals is None else gains.signals[:, 0]
        pairs = zip(self.settings.load_frequencies_rad_s, gains.resonators, strict=True)
        return {
            "ki": float(gains.ki[0]),
            "signals": dict(zip(self.signals, map(float, rows), strict=True)),
            "feed_forward": forward | {"coulomb_width": float(gains.width[0])},
            "resonators": [
                {"frequency_rad_s": x, "in_phase": float(along[0]), "quadrature": float(ahead[0])}
                for x, (along, ahead) in pairs
            ],
        }


#: Cut-off of the filter, in shares of the sampling frequency: lowest, highest, start.
CUT_OFF = (0.005, 1.0, 0.5)
#: Smallest searched ki, in shares of that of the PID with the smallest bandwidth.
SLOWEST = 1e-3
#: Largest searched kp, ki and kd, in multiples of those of the PID with the largest bandwidth.
FASTER = 10.0
#: Largest gain on a signal, in multiples of the larger one of the fastest and the first regulator.
LARGEST = 3.0
#: Gain of a resonator, in shares of kp x the resonator's frequency: lowest, highest, start.
RESONANT = (1e-3, 10.0, 0.3)
#: Largest lead or lag of a resonator's command relative to the best one in the nominal loop [rad].
ASIDE = 1.2
#: Ratio of a signal's first gain to the gain up to which its range is divided about linearly.
FINE = 10.0


class PidGenome(LinearGenome):
    """Genome of a PID's gains, its filter's cut-off, and gains on the settings' signals.

    Of each resonator the size of the gain is searched, and the lead of the command relative to the
    lead with which an error of the resonator's frequency fades fastest.
    """

    @property
    def signals(self) -> tuple[str, ...]:
        """Names of the signals in the settings."""
        return tuple(self.settings.signals)

    def designed(self, bandwidths: Floats) -> dict[str, Floats]:
        """Return gains of a PID; with signals, of a regulator that reads them, and ki of a PID."""
        kp, ki, kd = regulator.pid(self.model, bandwidths)
        if not self.signals:
            return {"kp": kp, "ki": ki, "kd": kd}
        of_signals = regulator.measured(self.model, self.signals, self.drive.name)
        gains = regulator.first_regulators(of_signals, kp, kd)
        return {"kp": gains.pop("error"), "ki": ki, "kd": gains.pop("error_rate"), **gains}

    def _searched(
        self, low: dict[str, float], high: dict[str, float], start: dict[str, float]
    ) -> dict[str, Searched]:
        ends = {**low, "ki": SLOWEST * low["ki"]}
        searched = {
            name: Searched(ends[name], FASTER * high[name], start[name])
            for name in ("kp", "ki", "kd")
        }
        cut_off = (share / self.every for share in CUT_OFF)
        searched["derivative_hz"] = Searched(*cut_off)
        for name in self.signals:
            most = LARGEST * max(abs(high[name]), abs(start[name]))
            bend = float(np.arcsinh(FINE * most / abs(start[name])))
            searched[name] = Searched(-most, most, start[name], bend)
        for name in self.settings.resonators:
            searched[name] = Searched(*RESONANT)
            searched[name + LEAD] = Searched(-ASIDE, ASIDE, 0.0)
        return searched

    def _feedback(self, values: dict[str, Floats]) -> dict[str, Floats]:
        cut_off, kp, kd = (values[name] for name in ("derivative_hz", "kp", "kd"))
        filter_pole = np.where(cut_off > 0.0, np.exp(-2.0 * np.pi * cut_off * self.every), 0.0)
        feedback = values | {"filter_pole": filter_pole}
        if self.settings.control == "cascade":  # Kv and 1/Tn are real: (kp - ki T)^2 >= 4 ki kd
            most = kp**2 / (4.0 * kd + 2.0 * kp * self.every)
            feedback["ki"] = np.minimum(values["ki"], most)
        each = zip(self.settings.resonators, self.settings.load_frequencies_rad_s, strict=True)
        for name, frequency in each:
            # The error is answer x the resonator's share; both fade where gain x answer < 0.
            z = np.exp(1j * frequency * self.every)
            answer = regulator.answer(self.model, feedback, self.signals, z, self.every)
            turn = -z * np.exp(1j * values[name + LEAD]) * np.abs(answer) / answer
            gain = values[name] * frequency * values["kp"] * turn
            feedback |= {name: gain.real, name + BEHIND: gain.imag}
        return feedback
