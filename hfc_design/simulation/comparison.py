"""What designs do side by side: in the same motions, on the same machines, and how it differs.

A design that does not hold a machine is not left out there: it has lost against every one that
does, whatever its numbers.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from hfc_design.core.faults import short
from hfc_design.core.numbers import Floats, Json, Mask, storable
from hfc_design.core.records import UserError
from hfc_design.core.shown import line, table
from hfc_design.core.statistics import Interval, share_interval
from hfc_design.core.wording import one_of
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.measured_in_use import tolerated_metrics
from hfc_design.simulation.monte_carlo import Robustness
from hfc_design.simulation.repeats import chaos_told
from hfc_design.simulation.settling import reasons_told

#: Parts of the names of the metrics that are compared, in the order of every table.
COMPARED = (
    *("rms_contour_error", "max_contour_error", "worst_glitch", "path_error", "orientation"),
    "rms_error",
    *("max_error", "overshoot", "settling_time", "_change", "peak_", "stick_share"),
)
#: Of these more is better, of every metric less.
SCORES = ("fitness", "merit")
#: What stands for all motions together.
EVERY = "every motion"
#: Shares of the machines that do as well as a number: half of them, nearly all.
HALF, NEARLY_ALL = 0.5, 0.95


class Side(NamedTuple):
    """One design in one motion, or in all: the nominal machine and every other."""

    stable: Mask  # (machines,)
    nominal_stable: bool
    nominal: dict[str, float]  # of each metric; nan where there is none
    values: dict[str, Floats]  # the same, (machines,)
    ranges: dict[str, Json] = {}  # of the nominal machine's scores that are chaotic

    def numbers(self) -> Json:
        """As plain data; None where there is no number."""
        metrics = {
            key: {
                "nominal": self.of_nominal(key),
                "median": self.quantile(key, HALF),
                "95_percent": self.quantile(key, NEARLY_ALL),
            }
            for key in self.values
        }
        return {
            "stable_share": float(self.stable.mean()),
            "stable_interval": list(self.interval),
            "nominal_stable": bool(self.nominal_stable),
            "repeats": self.ranges,
            "metrics": metrics,
        }

    @property
    def interval(self) -> Interval:
        """Where the share of stable machines lies among all that there could be."""
        return share_interval(int(self.stable.sum()), len(self.stable))

    def costs(self, key: str) -> Floats:
        """(machines,) by a metric, less is better; infinite without a number or if not stable."""
        found = -self.values[key] if key in SCORES else np.abs(self.values[key])
        return np.where(self.stable & np.isfinite(found), found, np.inf)

    def quantile(self, key: str, share: float) -> float | None:
        """The metric that a ``share`` of all machines does as well as; None: it has none."""
        found = float(np.quantile(self.costs(key), share, method="inverted_cdf"))
        return None if found == np.inf else (-found if key in SCORES else found)

    def span(self, key: str) -> tuple[float | None, float | None, float | None]:
        """The metric of the 5 %, the median and the 95 % machine."""
        return self.quantile(key, 0.05), self.quantile(key, 0.5), self.quantile(key, 0.95)

    def of_nominal(self, key: str) -> float | None:
        """The metric of the nominal machine, the lowest of chaotic ones; None: it has none.

        Of errors the magnitude, as of all machines (``costs``): signed ones cannot be ranked.
        """
        if key in self.ranges:
            return None if self.ranges[key]["lowest"] is None else float(self.ranges[key]["lowest"])
        found = self.nominal[key] if key in SCORES else abs(self.nominal[key])
        return found if self.nominal_stable and np.isfinite(found) else None


class Bout(NamedTuple):
    """The designs in one motion."""

    name: str
    scenario: Scenario | None  # of that motion alone; None of all motions together
    sides: dict[str, Side]  # by the designs' names
    found: dict[str, Robustness]  # empty of all motions together
    meanings: dict[str, str]  # of each metric, with its unit

    def compared(self) -> list[str]:
        """The metrics that are compared, the most important first, what is tolerated among them."""
        windows = () if self.scenario is None else self.scenario.windows
        heads = tuple(f"{window.name}_" for window in windows)
        keys = [key for key in self.meanings if not key.startswith(heads)]
        parts = [*COMPARED, *(() if self.scenario is None else tolerated_metrics(self.scenario))]
        return list(dict.fromkeys(key for part in parts for key in keys if part in key))

    def lost(self) -> Iterator[str]:
        """Why designs do not keep machines stable, a line each."""
        for name, one in self.found.items():
            told = [f"nominal machine {' and '.join(one.nominal_reasons)}"] * (
                not one.nominal_stable
            )
            if one.reasons:
                told += [f"of {len(one.stable)} others {reasons_told(one.reasons)}"]
            if told:
                yield f"{name} in {self.name}, not stable: {'; '.join(told)}"

    def chaos(self) -> Iterator[str]:
        """Which scores are chaotic on the nominal machine, a line each."""
        for name, side in self.sides.items():
            for key, found in side.ranges.items():
                if key in self.meanings:
                    yield f"{name} in {self.name}: {chaos_told(key, found)}"


class Difference(NamedTuple):
    """Two designs by one metric, paired machine by machine."""

    motion: str
    metric: str
    first: str
    second: str
    both: int  # machines that both keep stable; only the first, only the second, neither
    only_first: int
    only_second: int
    neither: int
    better: int  # machines on which the first is better, by its number or by being stable at all
    worse: int
    better_interval: Interval  # of the share of ``better`` in all machines
    ratio: float  # median of first over second where one is stable; 0: only the first
    ratio_interval: Interval | None
    p: float  # two-sided, of the same machines
    p_holm: float  # after Holm's correction for every difference of the comparison

    @property
    def machines(self) -> int:
        """All of them."""
        return self.both + self.only_first + self.only_second + self.neither

    def numbers(self) -> Json:
        """As plain data; None where there is no number."""
        return storable(self._asdict())


def spread_told(spread: float, tolerances: Mapping[str, float]) -> str:
    """How far machines are from the nominal one, in words."""
    single = (f", {name} ±{100 * own:g} %" for name, own in tolerances.items())
    return f"±{100 * spread:g} %{''.join(single)}"


class Comparison(NamedTuple):
    """What designs do side by side."""

    designs: dict[str, Design]
    spread: float
    seed: int
    machines: int
    bouts: list[Bout]  # one a motion, and if there are several one of all
    differences: list[Difference]
    notes: list[str]  # what is not alike
    tolerances: dict[str, float] = {}  # spreads of single parameters

    def __repr__(self) -> str:
        return line("Comparison", self._told())

    def _repr_html_(self) -> str:
        return table("Comparison", self._told())

    def _told(self) -> dict[str, object]:
        bouts = [bout.name for bout in self.bouts]
        told = {"designs": ", ".join(self.designs), "motions": ", ".join(bouts)}
        return {**told, "machines": self.machines, "within": self.within}

    @property
    def within(self) -> str:
        """How far the machines are from the nominal one, in words."""
        return spread_told(self.spread, self.tolerances)

    def of(self, motion: str, metric: str) -> list[Difference]:
        """The differences by a metric in a motion.

        Raises:
            UserError: there is no such motion, or it has no such metric, or one that stands in the
                tables and is not compared: each one more makes differences harder to show.
        """
        bouts = {bout.name: bout for bout in self.bouts}
        if motion not in bouts:
            raise UserError(f"motion {short(motion)}: is none here; {one_of(motion, bouts)}")
        if metric not in (known := bouts[motion].meanings):
            raise UserError(f"metric {short(metric)}: is none of {motion}; {one_of(metric, known)}")
        if metric not in (compared := bouts[motion].compared()):
            told = "is in the tables, its differences are not tested; those are of"
            raise UserError(f"metric {short(metric)}: {told} {', '.join(compared)}")
        return [x for x in self.differences if (x.motion, x.metric) == (motion, metric)]

    def numbers(self) -> Json:
        """Everything that its tables say as plain data; None where there is no number."""
        motions = {
            bout.name: {
                "meanings": bout.meanings,
                "designs": {name: side.numbers() for name, side in bout.sides.items()},
            }
            for bout in self.bouts
        }
        return {
            "designs": list(self.designs),
            "spread": self.spread,
            "tolerances": self.tolerances,
            "seed": self.seed,
            "machines": self.machines,
            "notes": self.notes,
            "motions": motions,
            "differences": [one.numbers() for one in self.differences],
        }
