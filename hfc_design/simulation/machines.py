"""Machines within tolerances: every physical parameter of every axis varies on its own.

A parameter is uniform within +-spread of its nominal value, independent of all others and of the
other axes; one that is 0 stays 0, and what ``Drive.exact`` names does not vary. A machine that
cannot exist (``Drive.fault``) is drawn again.
"""

from collections.abc import Mapping
from types import MappingProxyType

import jax
import numpy as np
from scipy.stats import qmc

from hfc_design.core.numbers import Floats, Parameters
from hfc_design.core.records import UserError
from hfc_design.files.machine import PlantSettings
from hfc_design.files.robust import unknown_parameter
from hfc_design.simulation.population import Machines

#: A spread is refused if it needs more than this many draws a machine.
MAX_DRAWS = 100
#: The option by which a user tells the spread.
KEY = "--spread"
NONE: Mapping[str, float] = MappingProxyType({})


def drawn(
    settings: PlantSettings,
    spread: float,
    samples: int,
    seed: int,
    tolerances: Mapping[str, float] = NONE,
    even: bool = False,
    key: str = KEY,
) -> tuple[Machines, int]:
    """The nominal machine and ``samples`` others, and how many draws gave no possible one.

    ``tolerances`` are the spreads of single parameters. ``even`` is a Latin hypercube: of every
    parameter each of ``samples`` parts of its range is met once, machines apart that had to be
    drawn again. Otherwise the first machines of a seed are the same for every number of samples.
    ``key`` is where the user told the spread.

    Raises:
        UserError: nearly no draw gives a possible machine, or a parameter is unknown.
    """
    drives, nominal = settings.machine.drives, settings.values()
    names = [name for own in nominal for name in own._fields]
    if told := unknown_parameter(settings, tolerances):
        raise UserError(f"{'--tolerance ' if key == KEY else 'robust.tolerances.'}{told}")
    exact = [name in drive.exact for drive in drives for name in drive.parameters._fields]
    width = np.where(exact, 0.0, [tolerances.get(name, spread) for name in names])
    generator = np.random.default_rng(seed)
    varied = np.flatnonzero(width)
    evenly = iter(qmc.LatinHypercube(len(varied), rng=generator).random(samples if even else 0))

    def draw() -> tuple[Parameters, ...]:
        factors = np.ones(len(names))
        place = next(evenly, None)
        if place is None:
            place = generator.random(len(varied))
        low, high = 1.0 - width[varied], 1.0 + width[varied]
        factors[varied] = low + (high - low) * place
        return _changed(nominal, factors)

    kept, refused = [nominal], 0
    while len(kept) <= samples:
        one = draw()
        if not any(drive.fault(own._asdict()) for drive, own in zip(drives, one, strict=True)):
            kept.append(one)
            continue
        refused += 1
        if refused > MAX_DRAWS * samples:
            told = f"{key}{' = ' if '.' in key else ' '}{spread:g}"
            raise UserError(
                f"{told}: of {refused + len(kept) - 1} draws only {len(kept) - 1} "
                f"gave a possible {settings.machine.name}; a smaller spread is needed"
            )
    true = jax.tree.map(lambda *numbers: np.array(numbers, np.float64), *kept)
    return Machines(nominal, true), refused


def _changed(nominal: tuple[Parameters, ...], factors: Floats) -> tuple[Parameters, ...]:
    """The parameters of each axis, times the factors of all."""
    values = np.concatenate([np.array(own, np.float64) for own in nominal]) * factors
    parts = np.split(values, np.cumsum([len(own) for own in nominal])[:-1])
    pairs = zip(nominal, parts, strict=True)
    return tuple(type(own)(*part.tolist()) for own, part in pairs)
