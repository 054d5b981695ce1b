"""Objectives of a front, by name: metrics, or the number of units that matter."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from hfc_design.core.wording import one_of
from hfc_design.objectives.metric import Metric, Units, path_fault
from hfc_design.objectives.metrics import RUNNING, metric

#: Name of an objective: the number of units of a hierarchy that matter, as its kind counts them.
UNITS = "units"
#: Names that stand for metrics: the first depends on the scenario, the second is short.
TRACKING, EFFORT = "tracking", "effort"
NAMES = (TRACKING, EFFORT, UNITS, *RUNNING, "band_time")
ALLOWED = 2, 3


class Traded(NamedTuple):
    """One objective of a front: the smaller, the better."""

    name: str  # as the user calls it
    unit: str  # "1" for none
    meaning: str
    metric: Metric | None  # None: the units that matter


def check_names(names: Sequence[str]) -> None:
    """Check two or three names; ValueError: too few or too many, one unknown, or one twice."""
    for name in names:
        if name not in NAMES:
            raise ValueError(f"{name}: unknown objective; {one_of(name, NAMES)}")
        if names.count(name) > 1:
            raise ValueError(f"{name}: is listed twice")
    if len(names) not in ALLOWED:
        raise ValueError(f"must be two or three objectives (got {len(names)})")


def traded(names: Sequence[str], fitness: Any, units: Units, path: bool) -> tuple[Traded, ...]:
    """Return the objectives with these names, for a scenario with that ``[fitness]``.

    ``tracking`` is the first metric among the targets that has the unit of the error. Without such
    a target, it is the rms of the contour error on a path, else of the tracking error. ``effort``
    is the rms of the command.

    Raises:
        ValueError: one needs a path or a band, or two are the same metric.
    """
    objectives: list[Traded] = []
    for name in names:
        if name == UNITS:
            objectives.append(Traded(name, "1", "units of the hierarchy that matter", None))
            continue
        known = metric(_measured(name, fitness, path), getattr(fitness, "band", None))
        if known.name == "band_time" and getattr(fitness, "band", None) is None:
            raise ValueError("band_time: needs fitness.band, of fitness.kind = 'tolerances'")
        words = [units.signals.get(word, word) for word in known.unit.split(" ")]
        objectives.append(Traded(name, " ".join(words), known.meaning, known))
    measures = [one.metric for one in objectives if one.metric is not None]
    if fault := path_fault(measures, path):
        raise ValueError(fault)
    for k, one in enumerate(objectives):
        for other in objectives[:k]:
            if one.metric is not None and one.metric == other.metric:
                raise ValueError(f"{other.name} and {one.name}: are the same quantity here")
    return tuple(objectives)


def _measured(name: str, fitness: Any, path: bool) -> str:
    """Return the name of the metric that the ``name`` of an objective stands for."""
    if name == EFFORT:
        return "rms_command"
    if name != TRACKING:
        return name
    for key in getattr(fitness, "tolerances", {}):
        if metric(key).unit == "error":
            return str(key)
    return "estimated_rms_contour_error" if path else "rms_error"
