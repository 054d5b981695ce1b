"""What is asked of a log: of which machine, in which loop, and which parameters are looked for."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.core.numbers import Floats, Parameters, Scalar
from hfc_design.core.wording import one_of
from plants import Drive

#: How far from where it began whatever a log does not tell may be.
FACTOR = 30.0
#: Factors of wrong units, mm or um for m, turns a minute, degrees. Others say nothing: a fit may
#: have begun with the values of quite another machine.
UNITS = np.log([1e3, 1e6, 60.0, 57.3])
#: Size of what may have either sign, and is 0 where it begins [its unit].
SMALL = 0.1
#: A load that is always there, beside the parameters; and those that are one, of some drives.
LOAD, OFFSETS = "load", frozenset({"offset", "unbalance", "gravity", "bias"})
#: Numbers behind those of the names: by how many samples the command acts late in all, and which
#: part of that is a first-order lag, of either sign.
LATE = ("delay_samples", "lag_s")


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Free:
    """The parameters that are looked for, and the ``LOAD``.

    Their numbers are logarithms where a sign is known, and shares of their sizes elsewhere; those
    of ``LATE`` follow. Names are compiled in, values not.
    """

    drive: Drive = field(metadata={"static": True})
    names: tuple[str, ...] = field(metadata={"static": True})
    start: Parameters  # everything, numbers
    load: Floats  # () where it begins
    scale: Floats  # (names,) size of each, in its unit
    positive: Floats  # (names,) 1 where it is more than zero, whatever it is
    begun: Floats  # (names + 2,) the numbers of the start
    near: Floats  # (names + 2,) the same where a search begins
    sought: Floats  # (2,) 1 where one of ``LATE`` may be looked for, 0 where it is known

    def parts(self, numbers: Scalar) -> tuple[Parameters, Scalar, Scalar, Scalar]:
        """The record with ``numbers`` (names + 2,) in it, late, lag and load; traced ones too."""
        own = numbers[:-2]
        values = jnp.where(self.positive > 0, self.scale * jnp.exp(own), self.scale * own)
        found = {name: values[k] for k, name in enumerate(self.names)}
        load = found.pop(LOAD, self.load) if LOAD not in self.start._fields else self.load
        return self.start._replace(**found), numbers[-2], jnp.abs(numbers[-1]), load

    @property
    def starts(self) -> dict[str, float]:
        """Where everything begins, what is not looked for too."""
        return {LOAD: float(self.load)} | {k: float(x) for k, x in self.start._asdict().items()}

    def unit(self, name: str) -> str:
        """What a parameter counts in; "" where the drive does not say it."""
        told = self.drive.parameter_units
        return told.get(name, self.drive.units["load"] if name == LOAD else "")

    def values(self, numbers: Floats) -> Floats:
        """(names,) in units of the drive."""
        own = np.asarray(numbers)[:-2]
        with np.errstate(over="ignore"):
            return np.where(self.positive > 0, self.scale * np.exp(own), self.scale * own)

    def shares(self, numbers: Floats) -> Floats:
        """(names,) by which share of itself each value changes with its number.

        What may have either sign, and ended near 0, by which share of where it began.
        """
        size = np.maximum(np.abs(np.asarray(numbers)[:-2]), 1.0)
        return np.where(self.positive > 0, 1.0, 1.0 / size)

    def rest(self) -> str:
        """What is not looked for and taken as it is, in a line; "" if there is nothing."""
        nominal = {LOAD: 0.0} | self.drive.parameters()._asdict()
        usual = {LOAD, *self.drive.exact}  # not worth a word where they are as they always are
        left = {k: x for k, x in self.starts.items() if k not in self.names}
        left = {k: x for k, x in left.items() if k not in usual or x != nominal[k]}
        known = "; set plant.parameters.NAME if you know better"
        return f"not looked for: {self._listed(left)}{known}" if left else ""

    def wanted(self) -> str:
        """What is looked for, with where it begins, in a line."""
        each = {name: self.starts[name] for name in self.names}
        late = zip(LATE, self.begun[-2:], self.sought, strict=True)
        return f"looked for, from: {self._listed(each)}" + "".join(
            f"; {name} {'from ' if open_ else 'known to be '}{x:.4g} samples"
            for name, x, open_ in late
            if open_ or x
        )

    def _listed(self, values: Mapping[str, float]) -> str:
        units = {name: self.unit(name) for name in values}
        told = (f"{k} {x:.6g} {units[k] if units[k] != '1' else ''}" for k, x in values.items())
        return ", ".join(map(str.strip, told))

    def away(self, numbers: Floats) -> dict[str, float]:
        """By which factor each parameter has left its start, of those that units may explain."""
        each = zip(self.names, self.values(numbers), self.positive, strict=True)
        factors = {name: float(x) / self.starts[name] for name, x, signed in each if x and signed}
        return {k: x for k, x in factors.items() if np.abs(abs(np.log(x)) - UNITS).min() < 0.1}


def free(
    drive: Drive,
    changes: Mapping[str, float],
    names: Sequence[str] | None = None,
    known: Collection[str] = (),
    around: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Free:
    """The parameters ``names`` of a drive, of which ``LOAD`` may be one.

    Args:
        drive: whose parameters.
        changes: values to start from.
        names: None: all that are neither exact nor 0 nor ``known``, and the load of a drive
            without one of ``OFFSETS`` among them.
        known: what stays as it is, of ``LATE`` too.
        around: the load [its unit], lateness and lag [samples] to start from.

    Raises:
        ValueError: one is unknown, or has no value to start from.
    """
    there = (*drive.parameters._fields, LOAD)
    if unknown := [name for name in (*changes, *(names or ())) if name not in there]:
        told = f"{drive.name} has no such parameter; {one_of(unknown[0], there)}"
        raise ValueError(f"{unknown[0][:60]}: {told}")
    start, fixed = drive.parameters(**changes), {*drive.exact, *known}
    if names is None:
        names = [x for x in start._fields if x not in fixed and getattr(start, x) != 0]
        if LOAD not in (*known, *start._fields) and OFFSETS.isdisjoint((*names, *known)):
            names.append(LOAD)
    sizes, signs, begun = [], [], []
    for name in (names := [*dict.fromkeys(names)]):
        own = name in start._fields
        value = float(getattr(start, name)) if own else around[0]
        signed = not own or drive.fault({**changes, name: -(value or SMALL)}) is None
        if value == 0.0 and not signed:
            raise ValueError(f"{name}: is 0; give it a value to start from: --free {name}=0.1")
        sizes.append(abs(value) or SMALL)
        signs.append(0.0 if signed else 1.0)
        begun.append(value / sizes[-1] if signed else 0.0)
    if not sizes:
        raise ValueError(f"names no parameter; {drive.name} has {', '.join(start._fields)}")
    sought = [float(name not in known) for name in LATE]
    begun += around[1:]
    numbers = (np.array(own) for own in (around[0], sizes, signs, begun, begun, sought))
    return Free(drive, tuple(names), start, *numbers)
