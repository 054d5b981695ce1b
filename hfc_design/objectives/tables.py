"""Tables of metrics: key, meaning and value of each column, for each kind of path."""

import re
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from hfc_design.objectives.metric import (
    ALONE,
    EACH,
    MACHINE,
    WORST,
    AxisRecord,
    Metric,
    MotionRecord,
)
from hfc_design.objectives.metrics import METRICS
from plants import Drive, Machine, in_a_name

#: Words in the unit of a metric that stand for the units of a drive's signals.
SIGNALS = re.compile(r"error_rate|error|command")


class Column(NamedTuple):
    """A column of a table of metrics: a metric of one machine, or of one axis."""

    meaning: str  # with the unit
    rank: int  # as in ``Metric``
    value: Callable[[MotionRecord], float | None]

    def of(self, name: str) -> "Column":
        """Return the column of a part with this ``name``, such as an axis or a motion."""
        return self._replace(meaning=f"{name}: {self.meaning}")


def columns(machine: Machine, table: str, directions: int = 0) -> dict[str, Column]:
    """Return key -> column, of the ``table`` ``ALONE``, ``PLANE`` or ``PROGRAM`` of a machine.

    ``directions`` is the number of those in which the path is a full circle.
    """
    listed = [one for one in METRICS if table in one.tables and one.directions <= directions]
    if table == ALONE:
        several, whole = len(machine.axes) > 1, dict[str, Column]()
        for k, (axis, drive) in enumerate(zip(machine.axes, machine.drives, strict=True)):
            for one in listed:
                key, meaning = labelled(one, drive)
                column = Column(meaning, one.rank, _of_axis(one, k))
                whole |= {f"{axis}_{key}": column.of(axis)} if several else {key: column}
        return whole
    existing = [one for one in listed if one.exists is None or one.exists(machine.drives)]
    return {key: column for one in existing for key, column in _of_machine(one, machine)}


def values(table: Mapping[str, Column], motion: MotionRecord) -> dict[str, float | None]:
    """Return the value of every column; None if it does not exist, or if the motion diverged."""
    finite = motion.finite
    return {key: column.value(motion) if finite else None for key, column in table.items()}


def labelled(metric: Metric, drive: Drive, which: str = "") -> tuple[str, str]:
    """Return key and meaning, with unit, of a ``drive``'s metric; ``which``: its axis in words."""
    units = dict(drive.units)
    unit = SIGNALS.sub(lambda match: units[match[0]], metric.unit)
    name = (metric.key or metric.name).replace("command", drive.command_name)
    tail = "" if unit == "1" else f"_{in_a_name(unit)}"
    key = metric.key.format(error=in_a_name(units["error"])) if "{" in name else name + tail
    meaning = re.sub(r"\bcommand\b", drive.command_name, metric.meaning)
    return key, f"{meaning}{which} [{unit}]"


def _of_axis(metric: Metric, k: int) -> Callable[[MotionRecord], float | None]:
    read = metric.recorded
    assert read is not None
    return lambda motion: read(motion.axes[k])


def _of_machine(metric: Metric, machine: Machine) -> Iterator[tuple[str, Column]]:
    """Yield the columns of a metric of a machine on a path, with their keys."""
    read, pairs = metric.recorded, [*zip(machine.axes, machine.drives, strict=True)]
    assert read is not None
    if metric.scope == MACHINE:
        unit = length_unit(machine) if metric.unit == "length" else metric.unit
        key = metric.name + ("" if unit == "1" else f"_{in_a_name(unit)}")
        yield key, Column(f"{metric.meaning} [{unit}]", metric.rank, read)
    elif metric.scope == EACH:
        for k, (axis, drive) in enumerate(pairs):
            key, meaning = labelled(metric, drive, f" of {axis.upper()}")
            yield f"{axis}_{key}", Column(meaning, metric.rank, _of_axis(metric, k))
    else:
        assert metric.scope == WORST
        alike: dict[tuple[str, str], list[int]] = {}
        for k, drive in enumerate(machine.drives):
            alike.setdefault(labelled(metric, drive, ", of the worst axis"), []).append(k)
        for (key, meaning), axes in alike.items():
            yield key, Column(meaning, metric.rank, _worst(read, axes))


def _worst(
    read: Callable[[AxisRecord], float | None], axes: list[int]
) -> Callable[[MotionRecord], float | None]:
    def worst(motion: MotionRecord) -> float | None:
        values = [value for k in axes if (value := read(motion.axes[k])) is not None]
        return max(values, default=None)

    return worst


def length_unit(machine: Machine) -> str:
    """Return the unit of length of the linear axes; "mm" if there are none."""
    return next((x.units["error"] for x in machine.drives if x.millimetres is not None), "mm")
