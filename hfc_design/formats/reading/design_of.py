"""A design of the system that was read, and of what the file does not say."""

import math
import re
from itertools import pairwise, product
from pathlib import Path
from typing import NamedTuple

from hfc_design.controllers.flc.record import nearest_labels
from hfc_design.controllers.hierarchical.record import input_names
from hfc_design.controllers.rules import FlatGaussian, Term
from hfc_design.core.records import NAME, TERMS, UserError, checked
from hfc_design.core.shapes import Json
from hfc_design.files.design import Design, named_design
from hfc_design.formats.reading.system import Input, System, centre_of, fault, triangle_records

HIERARCHY = "pd+hierarchical-fuzzy"
#: Kind -> plant where neither --plant nor --like says one.
PLANT_OF = {"flc": "feed-drive", "aflc": "feed-drive", HIERARCHY: "c-axis"}
SAMPLE_TIMES = {"feed-drive": 0.01, "c-axis": 0.001}  # [s]
#: What adapts in an aflc without --like.
ADAPTIVE = "jee-koren-2004-aflc"
#: Of a number; in 17 every float reads back.
DIGITS = range(1, 18)


class Wish(NamedTuple):
    """What the user says about the file."""

    kind: str | None = None
    name: str | None = None
    plant: str | None = None
    sample_time: float | None = None  # [s]
    like: str | None = None  # a design, for everything that the file does not hold
    signals: dict[str, str] = {}  # name of an input in the file -> the signal that it is


def design_of(system: System, wish: Wish, path: Path, digests: dict[str, str]) -> Design:
    """The design; ``digests`` are of the files that it was read from.

    Raises:
        UserError, ValueError: what the user says does not fit, what the file says does not.
    """
    shapes = [isinstance(item.terms[0], FlatGaussian) for item in system.inputs]
    if shapes[0] != shapes[1]:
        raise ValueError("one input has Gaussian terms and the other straight ones")
    like = None
    if wish.like is not None:
        from hfc_design.files.pairing import load_design  # with JAX

        like = load_design(wish.like)
    kind = wish.kind or (like.controller.kind if like else HIERARCHY if shapes[0] else "flc")
    if kind not in PLANT_OF or (like and like.controller.kind != kind):
        listed = " or ".join(PLANT_OF) if wish.kind is None else kind
        raise UserError(f"--like {wish.like}: has to be of kind {listed}")
    if (kind == HIERARCHY) != shapes[0]:
        needed = "Gaussian terms" if kind == HIERARCHY else "triangles"
        raise ValueError(f"kind {kind} needs {needed}, which are not what the file has")
    if kind == "aflc" and like is None:
        like = named_design(ADAPTIVE)
    plant_name = wish.plant or (like.plant.name if like else PLANT_OF[kind])
    plant: Json = {"name": plant_name, "parameters": {}}
    if like and like.plant.name == plant_name:
        plant = like.plant.model_dump()
    base = like.controller.model_dump() if like else {}
    controller = {"sample_time_s": SAMPLE_TIMES.get(plant_name)} | base | {"kind": kind}
    if wish.sample_time is not None:
        controller["sample_time_s"] = wish.sample_time
    if controller["sample_time_s"] is None:
        raise UserError(f"--sample-time: has to be given for the plant {plant_name}")
    signals = _signals(system, wish.signals)
    name = path.resolve().stem if wish.name is None else wish.name
    if not re.fullmatch(NAME, name):
        told = "a design's name is letters, digits, . _ and -, 64 at most"
        raise UserError(f"--name {name[:70]!r}: {told}")
    make = _hierarchy if kind == HIERARCHY else _fuzzy
    controller = make(controller, system, signals, plant_name)
    if kind == "aflc" and wish.like is None:
        controller = _with_room(controller)
    data = {
        "name": name,
        "plant": plant,
        "controller": controller,
        "provenance": {
            "source": f"imported from {path.name}",
            "sha256": digests,
            "terms": {item.name: [term.label for term in item.terms] for item in system.inputs},
        },
    }
    return checked(Design, data, path, path.parent)


def _signals(system: System, given: dict[str, str]) -> tuple[str, str]:
    """The signal that each input is."""
    names = [item.name for item in system.inputs]
    for name in given:
        if name not in names:
            raise UserError(f"--signal {name}: no such input; there is {', '.join(names)}")
    first, second = (given.get(name, name) for name in names)
    if first == second:
        raise ValueError(f"both inputs are the signal {first!r}")
    return first, second


def _known(system: System, signals: tuple[str, str], known: list[str]) -> None:
    for item, signal in zip(system.inputs, signals, strict=True):
        if signal not in known:
            raise fault(
                item.line,
                f"input {item.name!r}: which signal it is has to be said, as in --signal "
                f"{item.name or 'NAME'}={known[0]}; there is {', '.join(known)}",
            )


def _table(system: System, row: int) -> list[list[float]]:
    """Singletons (7, 7), rows by the terms of input ``row``, from the lowest to the highest."""
    first, second = system.inputs
    for i, j in product(_order(first), _order(second)):
        if (i, j) not in system.rules:
            one, other = first.terms[i].label, second.terms[j].label
            told = f"{first.name} is {one} and {second.name} is {other}"
            raise ValueError(f"there is no rule for {told}")
    table = [[system.rules[i, j][1] for j in _order(second)] for i in _order(first)]
    return table if row == 0 else [list(column) for column in zip(*table, strict=True)]


def _fuzzy(base: Json, system: System, signals: tuple[str, str], plant: str) -> Json:
    """Kind flc or aflc."""
    _known(system, signals, ["error", "error_change"])
    row = signals.index("error")
    table = _table(system, row)
    return {
        "integral_gain": 0.0,
        **base,
        "error_terms": _dumped(system.inputs[row]),
        "error_change_terms": _dumped(system.inputs[1 - row]),
        "rules": {"labels": nearest_labels(table), "centroids": table},
    }


def _with_room(controller: Json) -> Json:
    """An aflc; with overlaps of one step where they are too wide for its terms."""
    overlaps = controller["adaptation"]["smallest_overlap"]
    for key, overlap in overlaps.items():
        centres = [term["centre"] for term in controller[f"{key}_terms"]]
        if overlap > min(b - a for a, b in pairwise(centres)):
            adaptation = controller["adaptation"] | {"smallest_overlap": None}
            return controller | {"adaptation": adaptation}
    return controller


def _dumped(item: Input) -> list[Json]:
    return [term.model_dump() for term in triangle_records(item.terms)]


def _hierarchy(base: Json, system: System, signals: tuple[str, str], plant: str) -> Json:
    """A hierarchy of one unit; without --like it is the unit alone, without PD part and scales."""
    from hfc_design.files.machine import PlantSettings  # with JAX, and only needed here

    drive = PlantSettings(name=plant).machine.drives[0]
    _known(system, signals, input_names(drive.inputs))
    first, second = (tuple(sorted(item.terms, key=centre_of)) for item in system.inputs)
    for item in system.inputs:
        if item.low < -1.0 or item.high > 1.0:
            raise fault(item.line, f"input {item.name}: its range has to lie within -1 and 1")
    if [term[1:] for term in first] != [term[1:] for term in second]:
        raise ValueError("both inputs need the same terms; a hierarchy has one set of them")
    scales = {item["name"]: item["scale"] for item in base.get("inputs", ())}
    row, column = signals
    unit = {"id": 0, "column_input": column, "row_input": row, "consequents": _table(system, 0)}
    return {
        "pd": {"kp": 0.0, "kd": 0.0},
        "output_scale": 1.0,
        **base,
        "inputs": [{"name": name, "scale": scales.get(name, 1.0)} for name in (column, row)],
        "terms": _flat_gaussians(first),
        "units": [unit],
    }


def _flat_gaussians(terms: tuple[Term, ...]) -> list[Json]:
    """LL eq. 3 of each, in the shortest numbers that give what the file has bit for bit."""
    valid = all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,31}", term.label) for term in terms)
    records = []
    for k, term in enumerate(terms, 1):
        assert isinstance(term, FlatGaussian)
        centre = half = rate = 0.0
        for digits in DIGITS:
            centre = _rounded(0.5 * (term.low + term.high), digits)
            half = _rounded(0.5 * (term.high - term.low), digits)
            if (centre - half, centre + half) == (term.low, term.high):
                break
        for digits in DIGITS:
            rate = _rounded(0.5 / term.sigma**2, digits)
            if 1.0 / math.sqrt(2.0 * rate) == term.sigma:
                break
        label = term.label if valid else f"f{k}"
        records.append({"label": label, "centre": centre, "half_width": half, "rate": rate})
    return records


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _order(item: Input) -> list[int]:
    """Indices of the terms, from the lowest to the highest."""
    return sorted(range(TERMS), key=lambda k: centre_of(item.terms[k]))
