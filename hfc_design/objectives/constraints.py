"""Constraints: limits that a design must keep on every machine and in every motion."""

from typing import Annotated, NamedTuple, TypeAlias

from pydantic import AfterValidator

from hfc_design.core.records import Quantity
from hfc_design.objectives.metric import Metric, Units, in_units
from hfc_design.objectives.metrics import BAND_TIME, metric, named
from hfc_design.stability.margins import ASKED

#: Key in a table of constraints for the width of the band of the metric ``band_time``.
BAND = "band"


class Constraint(NamedTuple):
    """A metric and its largest allowed value, in the units of the machine."""

    metric: Metric
    most: float


def _known(most: dict[str, Quantity]) -> dict[str, Quantity]:
    for name, quantity in most.items():
        if name in ASKED:
            low, high = ASKED[name][2]
            if isinstance(quantity, str) or not low < quantity < high:
                reason = f"must be a number greater than {low:g} and less than {high:g}"
                raise ValueError(f"{name} = {quantity!r}: {reason}")
        elif name != BAND:
            metric(named(name))
    return {x if x in ASKED else named(x): quantity for x, quantity in most.items()}


#: The ``[constraints]`` of a scenario: metrics by name, each with its largest allowed value, and
#: margins of the loop (``ASKED``).
Constraints: TypeAlias = Annotated[dict[str, Quantity], AfterValidator(_known)]


def constraints_on(most: Constraints, units: Units) -> tuple[Constraint, ...]:
    """Return the constraints of metrics, with numbers in the units of a machine.

    Raises:
        ValueError: a limit has a unit of another quantity or is below 0, or the band is missing.
    """
    constraints, band = [], most.get(BAND)
    if BAND_TIME in most and band is None:
        raise ValueError(f"constraints.{BAND_TIME}: needs constraints.{BAND}")
    width = None if band is None else in_units(f"constraints.{BAND}", band, "error", units)
    for name, quantity in most.items():
        if name == BAND or name in ASKED:
            continue
        limited = metric(name, width)
        number = in_units(f"constraints.{name}", quantity, limited.unit, units)
        if not number >= 0.0:
            raise ValueError(f"constraints.{name} = {quantity!r}: must be at least 0")
        constraints.append(Constraint(limited, number))
    return tuple(constraints)
