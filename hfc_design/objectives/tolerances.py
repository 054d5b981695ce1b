"""Fitness by targets: the metrics of a motion divided by their desired values."""

from functools import cache, reduce
from typing import Annotated, Any, Literal

import jax.numpy as jnp
from jax.tree_util import Partial
from pydantic import Field, field_validator

from hfc_design.core.numbers import Scalar
from hfc_design.core.records import Positive, Quantity, Record
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives.metric import Metric, Units, in_units, path_fault
from hfc_design.objectives.metrics import BAND_TIME, metric, named
from hfc_design.objectives.objective import FINEST, Moment, Objective, ObjectiveSettings, Sums


class Weighed(Record):
    """A target with a weight other than 1."""

    tolerance: Quantity  # target: a number, or a string with a unit [of the metric]
    weight: Positive = 1.0  # weight relative to the others [1]


Tolerances = Annotated[dict[str, Quantity | Weighed], Field(min_length=1)]


class TolerancesSettings(ObjectiveSettings):
    """Metrics by name, each with its target."""

    kind: Literal["tolerances"] = "tolerances"
    #: targets: metrics by name, each with the value that is good enough: a number, a string with a
    #: unit, or a table { tolerance = ..., weight = ... } [of the metric]
    tolerances: Tolerances = {"settled_rms_error": 1e-3}
    #: width of the band for band_time: a number, or a string with a unit [error]
    band: Quantity | None = None

    @field_validator("tolerances")
    @classmethod
    def _known(cls, tolerances: Tolerances) -> Tolerances:
        for name in tolerances:
            metric(named(name))
        return {named(name): tolerated for name, tolerated in tolerances.items()}

    def on(self, units: Units) -> "TolerancesSettings":
        """Return the settings with plain numbers in the units of a machine.

        Raises:
            ValueError: a target has a unit of another quantity or is not above 0, or needs a band.
        """
        band = None if self.band is None else in_units("fitness.band", self.band, "error", units)
        if BAND_TIME in self.tolerances and band is None:
            raise ValueError(f"fitness.tolerances.{BAND_TIME}: needs fitness.band")
        converted: dict[str, Any] = {}
        for name, tolerated in self.tolerances.items():
            entry = tolerated if isinstance(tolerated, Weighed) else Weighed(tolerance=tolerated)
            key = f"fitness.tolerances.{name}"
            number = in_units(key, entry.tolerance, metric(name).unit, units)
            if not number > 0.0:
                raise ValueError(f"{key} = {entry.tolerance!r}: must be greater than 0")
            converted[name] = Weighed(tolerance=number, weight=entry.weight)
        return self.model_copy(update={"tolerances": converted, "band": band})


@cache
def tolerances(weighed: tuple[tuple[Metric, float, float], ...]) -> Objective:
    """Return the objective 1 / (weighted mean of metric / target); 1 just meets the targets.

    ``weighed`` has metrics, targets [units of the drive] and weights.
    """
    measures = [one for one, _, _ in weighed]
    whole = sum(weight for _, _, weight in weighed)
    values = tuple((weight / whole / size, one.value) for one, size, weight in weighed)
    alike = len({weight for *_, weight in weighed}) == 1
    names = ", ".join(
        f"{one.name} / {size:g} [{one.unit}]" + ("" if alike else f" (weight {weight:g})")
        for one, size, weight in weighed
    )
    return Objective(
        initial=Partial(_empty, tuple(one.initial for one in measures)),
        update=Partial(_update, tuple(one.update for one in measures)),
        score=Partial(_score, values),
        name="tolerances",
        title="fitness, by targets",
        unit="1",
        meaning=f"1 / weighted mean of {names}; 1 just meets the targets, higher is better",
        positive=True,
        settings=TolerancesSettings,
        make=lambda settings: tolerances(tolerated(settings)),
        fault=lambda axes, path: path_fault(measures, path),
    )


def _empty(each: tuple[Any, ...], zero: Scalar) -> Sums:
    return tuple(initial(zero) for initial in each)


def _update(
    each: tuple[Any, ...], sums: Sums, moments: tuple[Moment, ...], path: PathFrame | None
) -> Sums:
    pairs = zip(each, sums, strict=True)
    return tuple(update(totals, moments, path) for update, totals in pairs)


def _score(each: tuple[tuple[Scalar, Any], ...], sums: Sums) -> Scalar:
    pairs = zip(each, sums, strict=True)
    cost = reduce(jnp.add, [factor * value(totals) for (factor, value), totals in pairs])
    return 1.0 / jnp.maximum(cost, FINEST)


def tolerated(settings: TolerancesSettings) -> tuple[tuple[Metric, float, float], ...]:
    """Return metrics, targets [units of the drive] and weights; ``settings`` are from ``on``."""
    rows: list[Any] = []
    for name, weighed in settings.tolerances.items():
        assert isinstance(weighed, Weighed)  # after ``on``
        rows.append((metric(name, settings.band), weighed.tolerance, weighed.weight))
    return tuple(rows)


OBJECTIVE = tolerances(((metric("settled_rms_error"), 1e-3, 1.0),))
