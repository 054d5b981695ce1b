"""A laboratory in a page: the closed loop as WebAssembly, with all numbers that one may move."""

import base64
import zlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import jax
import numpy as np
from numpy.typing import ArrayLike

from hfc_design.core.numbers import Floats, Json
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design, machine
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.formats.loop_code import LoopCode, loop_code, loop_of, numbers_of, rows
from hfc_design.reference.entries import keys_in
from hfc_design.report import Page, rendered
from hfc_design.simulation.usable import unseen

#: Machines beside the nominal one; numbers of a list that are still sliders, in more they are not.
MACHINES, FEW = 199, 8
#: Ends of a slider as factors on a number, and as numbers where it is 0.
FACTORS, ENDS = (0.1, 10.0), (0.0, 1.0)
#: Changes of a number at which its effect on the gains is seen, and must be linear.
TRIED = 1.1, 0.6


class Slider(NamedTuple):
    """A number that can be moved."""

    key: str  # of the design, or the name of a parameter
    label: str
    unit: str
    value: float
    low: float
    high: float
    of: str  # array that it changes: "gains", "parameters" or "loop"
    effects: list[tuple[int, float]]  # index in it, and change there for a change by 1


def laboratory(design: Design, scenario: Scenario) -> Json:
    """Return what the script of the page needs; UserError: there is no code of this loop."""
    code = loop_code(design, scenario)
    motions = []  # in a list, as keys of a page are sorted
    for name, motion in named_motions(scenario).items():
        steps = motion.simulation.steps
        columns = _columns(rows(motion.samples(), steps))
        motions.append({"name": name, "steps": steps, "columns": columns})
    machines = unseen(design, scenario, MACHINES)
    parameters = [np.asarray(leaf) for leaf in jax.tree.leaves(machines.actual)]
    doubles = {name: getattr(code, name) for name in ("loop", "parameters", "gains", "start")}
    doubles["machines"] = np.stack(parameters, axis=1)  # the nominal one first
    data = code._asdict() | {"module": _text(code.module), "motions": motions}
    data |= {name: packed(values) for name, values in doubles.items()}
    plant, units = machine(design, scenario), scenario.units.signals
    data["axes"] = [one.name for one in plant.each()] if plant.axes else [""]
    data["units"] = {name: units[name] for name in ("error", "command")}
    data["most"] = MACHINES + 1
    data["design"] = design.model_dump(mode="json")
    data["sliders"] = [one._asdict() for one in sliders(design, scenario, code)]
    return data


def laboratory_page(design: Design, scenario: Scenario) -> Page:
    """Return a page with nothing but the laboratory; UserError as in ``laboratory``."""
    known = laboratory(design, scenario)
    return rendered("laboratory.html.j2", design.name, name=design.name, laboratory=known)


def named_motions(scenario: Scenario) -> dict[str, Scenario]:
    """Return the scenario of each motion by name."""
    names = [one.name for one in scenario.motions] or [scenario.name]
    return dict(zip(names, scenario.each_motion(), strict=True))


def sliders(design: Design, scenario: Scenario, code: LoopCode) -> Iterator[Slider]:
    """Yield the gains of a design, parameters of the nominal machine, limits and sensors."""
    for key, value in _moved(design.controller.model_dump(), "controller"):

        def gains(x: float, key: str = key) -> list[float]:
            return numbers_of(load_design(design, {key: x}).controller.law_gains())

        if effects := _effects(gains, value, code.gains):
            about = key.removeprefix("controller."), "", value, *_ends(value)
            yield Slider(key, *about, "gains", effects)
    place, several = 0, bool(scenario.plant.machine.axes[1:])
    for axis in machine(design, scenario).each():
        for name, value in axis.parameters._asdict().items():
            unit = axis.drive.parameter_units.get(name, "")
            label = f"{axis.name} {name}" if several else name
            about = label, unit * (unit != "1"), value, *_ends(value)
            yield Slider(name, *about, "parameters", [(place, 1.0)])
            place += 1
    form, keys = loop_of(design, scenario)[0].apart[0], keys_in(scenario.model_dump())
    for table in ("limits", "sensors"):
        for key, value in _moved(getattr(scenario, table).model_dump(), table):

            def loop(x: float, key: str = key) -> list[float]:
                other, numbers = loop_of(design, load_scenario(scenario, {key: x}))[0].apart
                return [*numbers] if other == form else []  # of another program

            if value and (effects := _effects(loop, value, code.loop)):
                yield Slider(key, key, keys.unit(key), value, *_ends(value), "loop", effects)


def _ends(value: float) -> tuple[float, float]:
    low, high = sorted(x * value for x in FACTORS)
    return (low, high) if value else ENDS


def _moved(value: Any, key: str) -> Iterator[tuple[str, float]]:
    if isinstance(value, Mapping):
        for name, part in value.items():
            if name != "sample_time_s":
                yield from _moved(part, f"{key}.{name}")
    elif isinstance(value, list | tuple) and len(value) <= FEW:
        for k, part in enumerate(value):
            if not isinstance(part, list | tuple):
                yield from _moved(part, f"{key}.{k}")
    elif isinstance(value, float):
        yield key, value


def _effects(
    numbers: Callable[[float], list[float]], value: float, begun: list[float]
) -> list[tuple[int, float]]:
    """Return how a number changes others, from ``begun``; [] if not at all, or not linearly."""
    slopes = list[Floats]()
    for factor in TRIED:
        moved = factor * value or factor
        try:
            after = np.array(numbers(moved))
        except UserError:
            return []
        if len(after) != len(begun):
            return []
        with np.errstate(invalid="ignore"):  # infinite ones do not change
            slopes.append(np.nan_to_num((after - begun) / (moved - value)))
    first, second = slopes
    if not np.allclose(first, second, rtol=1e-9, atol=1e-12):
        return []
    return [(int(k), float(first[k])) for k in np.flatnonzero(first)]


def _columns(table: Floats) -> list[Any]:
    """Return columns packed; a number where one is constant, the index of an equal one before."""
    first: dict[bytes, int] = {}
    columns = list[Any]()
    for k, x in enumerate(table.T.astype(float)):
        if (x == x[0]).all():
            columns.append(float(x[0]))
        else:
            same = first.setdefault(x.tobytes(), k)
            columns.append([same] if same < k else packed(x))
    return columns


def packed(values: ArrayLike) -> str:
    """Return doubles as a text, without loss: a fifth as long for most motions.

    Differences of differences of their bits as whole numbers, their first bytes, then their second
    ones and so on, deflated.
    """
    bits = np.ascontiguousarray(values, float).ravel().view(np.int64)
    for _ in range(2):
        bits = np.diff(bits, prepend=np.int64(0))
    return _text(bits.view(np.uint8).reshape(-1, 8).T.tobytes())


def _text(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()
