"""Machines within tolerances: every physical parameter of every axis varies independently.

A parameter is uniform within +-spread of its nominal value, independent of all others and of the
other axes; a parameter that is 0 stays 0, and those in ``Drive.exact`` do not vary. A machine that
cannot exist (``Drive.fault``) is drawn again. Effects around the drives (``AROUND``) vary too, if
they have a tolerance and no parameter has the same name.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import jax
import numpy as np
from scipy.stats import qmc

from hfc_design.core.numbers import Floats, Integers, Parameters
from hfc_design.core.records import UserError, either, option
from hfc_design.files.machine import PlantSettings
from hfc_design.files.robust import AROUND, friction_of, unknown_parameter
from hfc_design.simulation.population import Machines
from plants import Drive

#: A spread is refused if it needs more than this many draws a machine.
MAX_DRAWS = 100
NONE: Mapping[str, float] = MappingProxyType({})


def drawn(
    settings: PlantSettings,
    spread: float,
    samples: int,
    seed: int,
    tolerances: Mapping[str, float] = NONE,
    even: bool = False,
    key: str | None = None,
) -> tuple[Machines, int]:
    """Return the nominal machine and ``samples`` drawn ones, and how many draws were impossible.

    ``tolerances`` are the spreads of single parameters. With ``even`` the draw is a Latin
    hypercube: each of ``samples`` parts of every parameter's range is used once, except for
    machines that had to be drawn again. Otherwise the first machines of a seed are the same for
    every number of samples. ``key`` names the spread in messages if it is from a file.

    Raises:
        UserError: nearly no draw gives a possible machine, or a parameter is unknown.
    """
    drives, nominal = settings.machine.drives, settings.values()
    names = [name for parameters in nominal for name in parameters._fields]
    if message := unknown_parameter(settings, tolerances):
        place = "robust.tolerances." if key else either("--tolerance ", "tolerances: ")
        raise UserError(place + message)
    exact = [name in drive.exact for drive in drives for name in drive.parameters._fields]
    width = np.where(exact, 0.0, [tolerances.get(name, spread) for name in names])
    groups = _groups(drives, tolerances)
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
        for indices, most in groups:
            factors[indices] *= generator.uniform(1.0 - most, 1.0 + most)
        return _changed(nominal, factors)

    accepted, refused = [nominal], 0
    while len(accepted) <= samples:
        one = draw()
        if not any(drive.fault(x._asdict()) for drive, x in zip(drives, one, strict=True)):
            accepted.append(one)
            continue
        refused += 1
        if refused > MAX_DRAWS * samples:
            setting = f"{key} = {spread:g}" if key else option("spread", spread)
            few = f"only {len(accepted) - 1} of {refused + len(accepted) - 1} draws gave"
            possible = f"a possible {settings.machine.name}; reduce the spread"
            raise UserError(f"{setting}: {few} {possible}")
    true = jax.tree.map(lambda *numbers: np.array(numbers, np.float64), *accepted)
    around = {
        name: _around(name, tolerances[name], (len(drives), samples + 1), [seed, k])
        for k, name in enumerate(AROUND)
        if name in tolerances and name not in names and not name.startswith("friction")
    }
    return Machines(nominal, true, around), refused


def _around(name: str, most: float, shape: tuple[int, int], seed: list[int]) -> Floats:
    """Return values (axes, machines) of an effect around drives; the first machine is nominal."""
    place = np.random.default_rng(seed).uniform(0.0 if name == "backlash" else -1.0, 1.0, shape)
    place[:, 0] = 0.0
    return most * place + (name == "noise")


def _groups(
    drives: Sequence[Drive], tolerances: Mapping[str, float]
) -> list[tuple[Integers, float]]:
    """Return groups of friction parameters with a common factor: indices, and its tolerance."""
    groups, begin = [], 0
    for drive in drives:
        places = {name: begin + k for k, name in enumerate(drive.parameters._fields)}
        for rest, name in ((True, "friction_at_rest"), (False, "friction_moving")):
            indices = [places[x] for x in friction_of(drive, rest, not rest)]
            if name in tolerances and indices:
                groups.append((np.array(indices), tolerances[name]))
        begin += len(places)
    return groups


def _changed(nominal: tuple[Parameters, ...], factors: Floats) -> tuple[Parameters, ...]:
    """Return the parameters of each axis times ``factors`` (those of all axes in a row)."""
    values = np.concatenate([np.array(parameters, np.float64) for parameters in nominal]) * factors
    parts = np.split(values, np.cumsum([len(parameters) for parameters in nominal])[:-1])
    pairs = zip(nominal, parts, strict=True)
    return tuple(type(parameters)(*part.tolist()) for parameters, part in pairs)
