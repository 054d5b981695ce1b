"""Parameters of a machine that are identified, and the numbers by which a fit changes them."""

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

#: Factor between a parameter and its start that counts as one standard deviation before the fit.
FACTOR = 30.0
#: Logarithms of factors that suggest a wrong unit: mm or um for m, rev/min, degrees. Other factors
#: show nothing: a fit may start with the values of a very different machine.
UNITS = np.log([1e3, 1e6, 60.0, 57.3])
#: Largest distance from such a factor, as a logarithm: start values are a third off, too.
NEAR = 0.4
#: Scale of a parameter of either sign that starts at 0 [its unit].
SMALL = 0.1
#: Name of a constant load that is not a parameter; parameters of some drives that act like it.
LOAD, OFFSETS = "load", frozenset({"offset", "unbalance", "gravity", "bias"})
#: The last two numbers of a fit, after those of the parameters: total delay of the command, and the
#: part of it that is a first-order lag (its sign has no meaning), both in samples.
LATE = ("delay_samples", "lag_s")


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class FreeParameters:
    """Parameters that are identified, which may include ``LOAD``, and numbers that stand for them.

    The number of a parameter that must be positive is ln(value / scale), of another value / scale.
    Two numbers for ``LATE`` follow. A compiled program depends on the names, not on the values.
    """

    drive: Drive = field(metadata={"static": True})
    names: tuple[str, ...] = field(metadata={"static": True})
    start: Parameters  # record of all parameters of the drive at the start
    load: Floats  # () constant load at the start
    scale: Floats  # (names,) size of each parameter, in its unit
    positive: Floats  # (names,) 1 for a parameter that must be positive, else 0
    begun: Floats  # (names + 2,) numbers at the start
    sought: Floats  # (2,) 1 if this one of ``LATE`` may be fitted, 0 if it is known

    def values(self, numbers: Scalar, xp: Any = np) -> Scalar:
        """Return the values (names,) of ``numbers`` in units of the drive; ``xp=jnp`` if traced."""
        numbers = numbers[:-2]
        with np.errstate(over="ignore"):
            size = xp.where(self.positive > 0, xp.exp(numbers), numbers)
            return self.scale * size

    def parts(self, numbers: Scalar) -> tuple[Parameters, Scalar, Scalar, Scalar]:
        """Return what ``numbers`` (names + 2,) stand for: parameters, delay, lag and load."""
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
        """Return the unit of a parameter; "" if the drive does not define it."""
        default = self.drive.units["load"] if name == LOAD else ""
        return self.drive.parameter_units.get(name, default)

    def shares(self, numbers: Floats) -> Floats:
        """Return (names,) the relative change of each value per change of its number.

        For a parameter of either sign that is smaller than its scale, it is relative to the scale.
        """
        return np.where(self.positive > 0, 1.0, 1.0 / np.maximum(np.abs(numbers[:-2]), 1.0))

    def rest(self) -> str:
        """Return a line on the parameters that are not identified; "" if there are none."""
        nominal = {LOAD: 0.0} | self.drive.parameters()._asdict()
        usual = {LOAD, *self.drive.exact}  # mentioned only if they differ from the nominal drive
        left = {k: x for k, x in self.starts.items() if k not in self.names}
        left = {k: x for k, x in left.items() if k not in usual or x != nominal[k]}
        hint = "; set plant.parameters.NAME if you know the value"
        return f"not identified: {self._listed(left)}{hint}" if left else ""

    def wanted(self) -> str:
        """Return a line on the parameters to identify, with their start values."""
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
        """Return value / start of positive parameters, where it looks like a factor of a unit."""
        rows = zip(self.names, self.values(numbers), self.positive, strict=True)
        factors = {name: float(x) / self.starts[name] for name, x, positive in rows if positive}
        off = {k: np.abs(abs(np.log(x)) - UNITS).min() for k, x in factors.items() if x}
        return {k: factors[k] for k, x in off.items() if x < NEAR}


def free_parameters(
    drive: Drive,
    changes: Mapping[str, float],
    names: Sequence[str] | None = None,
    known: Collection[str] = (),
    around: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> FreeParameters:
    """Return the parameters of a drive that are to be identified.

    Args:
        drive: drive of the parameters.
        changes: start values that differ from the nominal drive.
        names: parameters to identify, perhaps ``LOAD`` too; None: all that are not exact, 0 or
            ``known``, and ``LOAD`` unless one of ``OFFSETS`` is identified or known.
        known: parameters that keep their value, perhaps ``LOAD`` and those of ``LATE`` too.
        around: load [unit of the drive], total delay and lag [samples] to start from.

    Raises:
        ValueError: a parameter is unknown or has no value to start from, or none is left.
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
