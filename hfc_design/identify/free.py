"""Which parameters of a machine are looked for, and the numbers that a fit changes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.core.numbers import Floats, Parameters, Scalar
from hfc_design.core.wording import one_of
from plants import Drive

#: Whatever ends further than by this factor from where it began is told: units may be wrong.
FACTOR = 30.0
#: Size of what may have either sign, and is 0 where it begins [its unit].
SMALL = 0.1


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Free:
    """The parameters that are looked for.

    Their numbers are logarithms where a sign is known, and shares of their sizes elsewhere; one
    more number says by how many samples the command is late. Names are compiled in, values not.
    """

    drive: Drive = field(metadata={"static": True})
    names: tuple[str, ...] = field(metadata={"static": True})
    start: Parameters  # everything, numbers
    scale: Floats  # (names,) size of each, in its unit
    positive: Floats  # (names,) 1 where it is more than zero, whatever it is
    begun: Floats  # (names + 1,) the numbers of the start

    def parameters(self, numbers: Scalar) -> Parameters:
        """The record with ``numbers`` (names + 1,) in it; traced ones too."""
        own = numbers[:-1]
        values = jnp.where(self.positive > 0, self.scale * jnp.exp(own), self.scale * own)
        return self.start._replace(**{name: values[k] for k, name in enumerate(self.names)})

    def values(self, numbers: Floats) -> Floats:
        """(names,) in units of the drive."""
        own = np.asarray(numbers)[:-1]
        with np.errstate(over="ignore"):
            return np.where(self.positive > 0, self.scale * np.exp(own), self.scale * own)

    def shares(self, numbers: Floats) -> Floats:
        """(names,) by which share of itself each value changes with its number.

        What may have either sign, and ended near 0, by which share of where it began.
        """
        size = np.maximum(np.abs(np.asarray(numbers)[:-1]), 1.0)
        return np.where(self.positive > 0, 1.0, 1.0 / size)

    def rest(self) -> str:
        """What is not looked for and taken as it is, in a line; "" if there is nothing."""
        names = [x for x in self.start._fields if x not in (*self.names, *self.drive.exact)]
        values = {name: float(getattr(self.start, name)) for name in names}
        units = {x: unit for x, unit in self.drive.parameter_units.items() if unit != "1"}
        told = [f"{x} {value:.6g} {units.get(x, '')}".strip() for x, value in values.items()]
        known = "; set plant.parameters.NAME if you know better"
        return f"not looked for: {', '.join(told)}{known}" if told else ""

    def away(self, numbers: Floats) -> dict[str, float]:
        """By which factor each parameter has left its start, of those that left it far."""
        value = dict(zip(self.names, self.values(numbers), strict=True))
        factors = {name: x / getattr(self.start, name) for name, x in value.items() if x}
        known = dict(zip(self.names, self.positive, strict=True))
        return {
            name: float(factor)
            for name, factor in factors.items()
            if known[name] and not 1.0 / FACTOR < factor < FACTOR
        }


def free(drive: Drive, changes: Mapping[str, float], names: Sequence[str] | None = None) -> Free:
    """The parameters ``names`` of a drive; None: all that are neither exact nor 0.

    ``changes`` are values to start from.

    Raises:
        ValueError: one is unknown, or has no value to start from.
    """
    start = drive.parameters(**changes)
    if names is None:
        names = [
            name for name in start._fields if name not in drive.exact and getattr(start, name) != 0
        ]
    sizes, signs, begun = [], [], []
    for name in (names := [*dict.fromkeys(names)]):
        if name not in start._fields:
            told = one_of(name, start._fields)
            raise ValueError(f"{name[:60]}: {drive.name} has no such parameter; {told}")
        value = float(getattr(start, name))
        signed = drive.fault({**changes, name: -(value or SMALL)}) is None
        if value == 0.0 and not signed:
            key = f"plant.parameters.{name}"
            raise ValueError(f"{name}: is 0; give it a value to start from: --set {key}=0.1")
        sizes.append(abs(value) or SMALL)
        signs.append(0.0 if signed else 1.0)
        begun.append(value / sizes[-1] if signed else 0.0)
    if not sizes:
        raise ValueError(f"names no parameter; {drive.name} has {', '.join(start._fields)}")
    numbers = (np.array(own) for own in (sizes, signs, [*begun, 0.0]))
    return Free(drive, tuple(names), start, *numbers)
