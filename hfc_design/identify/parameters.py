"""Parameters of a machine that are identified, as the numbers that a fit changes."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.core.numbers import Floats, Parameters, Scalar
from hfc_design.core.records import either
from hfc_design.core.wording import one_of
from plants import Drive

#: Largest factor between an undetermined parameter and its start.
FACTOR = 30.0
#: Factors that show a wrong unit: mm or um for m, rev/min, degrees. Other factors show nothing: a
#: fit may start with the values of a very different machine.
UNITS = np.log([1e3, 1e6, 60.0, 57.3])
#: Scale of a parameter of either sign that starts at 0 [its unit].
SMALL = 0.1
#: A constant load beside the parameters; and parameters of some drives that are such a load.
LOAD, OFFSETS = "load", frozenset({"offset", "unbalance", "gravity", "bias"})
#: Numbers after those of the names: total delay of the command in samples, and the part of it
#: that is a first-order lag, of either sign.
LATE = ("delay_samples", "lag_s")


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class FreeParameters:
    """The parameters that are identified, and the ``LOAD``.

    Their numbers are logarithms for parameters of known sign, and shares of their scales otherwise;
    those of ``LATE`` follow. Names are compiled in, values are not.
    """

    drive: Drive = field(metadata={"static": True})
    names: tuple[str, ...] = field(metadata={"static": True})
    start: Parameters  # everything, numbers
    load: Floats  # () where it begins
    scale: Floats  # (names,) size of each, in its unit
    positive: Floats  # (names,) 1 where it is more than zero, whatever it is
    begun: Floats  # (names + 2,) the numbers of the start
    sought: Floats  # (2,) 1 where one of ``LATE`` may be looked for, 0 where it is known

    def values(self, numbers: Scalar, xp: Any = np) -> Scalar:
        """Values (names,) in units of the drive; traced ``numbers`` need ``xp=jnp``."""
        numbers = numbers[:-2]
        with np.errstate(over="ignore"):
            size = xp.where(self.positive > 0, xp.exp(numbers), numbers)
            return self.scale * size

    def parts(self, numbers: Scalar) -> tuple[Parameters, Scalar, Scalar, Scalar]:
        """The record with ``numbers`` (names + 2,), delay, lag and load; also if traced."""
        values = self.values(numbers, jnp)
        changes = {name: values[k] for k, name in enumerate(self.names)}
        known = LOAD in self.start._fields
        load = self.load if known else changes.pop(LOAD, self.load)
        return self.start._replace(**changes), numbers[-2], jnp.abs(numbers[-1]), load

    @property
    def starts(self) -> dict[str, float]:
        """Start values of all parameters, including those that are not identified."""
        return {LOAD: float(self.load)} | {k: float(x) for k, x in self.start._asdict().items()}

    def unit(self, name: str) -> str:
        """Unit of a parameter; "" if the drive does not define it."""
        default = self.drive.units["load"] if name == LOAD else ""
        return self.drive.parameter_units.get(name, default)

    def shares(self, numbers: Floats) -> Floats:
        """(names,) relative change of each value with its number.

        For a parameter of either sign that ended near 0, relative to its start.
        """
        return np.where(self.positive > 0, 1.0, 1.0 / np.maximum(np.abs(numbers[:-2]), 1.0))

    def rest(self) -> str:
        """Line on the parameters that are taken as they are; "" if there are none."""
        nominal = {LOAD: 0.0} | self.drive.parameters()._asdict()
        usual = {LOAD, *self.drive.exact}  # not worth a word where they are as they always are
        left = {k: x for k, x in self.starts.items() if k not in self.names}
        left = {k: x for k, x in left.items() if k not in usual or x != nominal[k]}
        hint = "; set plant.parameters.NAME if you know the value"
        return f"not identified: {self._listed(left)}{hint}" if left else ""

    def wanted(self) -> str:
        """Line on the identified parameters with their start values."""
        values = self._listed({x: self.starts[x] for x in self.names})
        line = f"to identify, with start values: {values}"
        for name, samples, open_ in zip(LATE, self.begun[-2:], self.sought, strict=True):
            if open_ or samples:
                line += f"; {name} {'from ' if open_ else 'known to be '}{samples:.4g} samples"
        return line

    def _listed(self, values: Mapping[str, float]) -> str:
        units = {name: self.unit(name) for name in values}
        return ", ".join(
            f"{k} {x:.6g} {units[k] if units[k] != '1' else ''}".strip() for k, x in values.items()
        )

    def away(self, numbers: Floats) -> dict[str, float]:
        """Factors between parameters and their starts, of those that wrong units may explain."""
        rows = zip(self.names, self.values(numbers), self.positive, strict=True)
        factors = {name: float(x) / self.starts[name] for name, x, positive in rows if positive}
        return {
            k: x for k, x in factors.items() if x and np.abs(abs(np.log(x)) - UNITS).min() < 0.1
        }


def free_parameters(
    drive: Drive,
    changes: Mapping[str, float],
    names: Sequence[str] | None = None,
    known: Collection[str] = (),
    around: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> FreeParameters:
    """The parameters ``names`` of a drive, which may include ``LOAD``.

    Args:
        drive: drive of the parameters.
        changes: values to start from.
        names: None: all that are neither exact nor 0 nor ``known``, and the load of a drive
            without one of ``OFFSETS`` among them.
        known: parameters that are kept, which may include those of ``LATE``.
        around: the load [its unit], delay and lag [samples] to start from.

    Raises:
        ValueError: a parameter is unknown, or has no value to start from.
    """
    parameters = drive.parameters._fields
    if unknown := [x for x in (*changes, *(names or ())) if x not in (*parameters, LOAD)]:
        there = one_of(unknown[0], (*parameters, LOAD))
        raise ValueError(f"{unknown[0][:60]}: unknown parameter of {drive.name}; {there}")
    start = drive.parameters(**changes)
    values = {LOAD: around[0]} | start._asdict()
    if names is None:
        fixed = {*drive.exact, *known}
        names = [x for x in parameters if x not in fixed and values[x] != 0]
        if LOAD not in (*known, *parameters) and OFFSETS.isdisjoint((*names, *known)):
            names.append(LOAD)
    if not names:
        raise ValueError(f"must name parameters; available: {', '.join(parameters)}")
    sizes, positive, begun = [], [], []
    for name in (names := [*dict.fromkeys(names)]):
        value = float(values[name])
        negative = {**changes, name: -(value or SMALL)}
        signed = name not in parameters or drive.fault(negative) is None
        if value == 0.0 and not signed:
            example = either(f"--free {name}=0.1", f"free=['{name}=0.1']")
            raise ValueError(f"{name}: is 0; give a start value: {example}")
        sizes.append(abs(value) or SMALL)
        positive.append(float(not signed))
        begun.append(value / sizes[-1] if signed else 0.0)
    sought = [float(name not in known) for name in LATE]
    numbers = map(np.array, (around[0], sizes, positive, [*begun, *around[1:]], sought))
    return FreeParameters(drive, tuple(names), start, *numbers)
