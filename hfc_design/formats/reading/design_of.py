"""A design of the system that was read, and of what the file does not say."""

import math
import re
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from hfc_design.controllers.flc.record import nearest_labels
from hfc_design.controllers.hierarchical.settings import input_names
from hfc_design.controllers.rules import FlatGaussian, Term
from hfc_design.core.records import NAME, TERMS, UserError, checked
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
        UserError: what the user says does not fit.
        ValueError: what the file says does not.
    """
    shapes = [isinstance(item.terms[0], FlatGaussian) for item in system.inputs]
    if shapes[0] != shapes[1]:
        raise ValueError("one input has Gaussian terms and the other straight ones")
    like = None if wish.like is None else _with_known_plant(wish.like)
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
    plant: dict[str, Any] = {"name": plant_name, "parameters": {}}
    if like and like.plant.name == plant_name:
        plant = like.plant.model_dump()
    base = like.controller.model_dump() if like else {}
    controller = {"sample_time_s": SAMPLE_TIMES.get(plant_name)} | base | {"kind": kind}
    if wish.sample_time is not None:
        controller["sample_time_s"] = wish.sample_time
    if controller["sample_time_s"] is None:
        raise UserError(f"--sample-time: has to be given for the plant {plant_name}")
    signals = _signals(system, wish.signals)
    make = _hierarchy if kind == HIERARCHY else _fuzzy
    data: dict[str, Any] = {
        "name": _name(wish, path),
        "plant": plant,
        "controller": make(controller, system, signals, plant_name),
        "provenance": {
            "source": f"imported from {path.name}",
            "sha256": digests,
            "terms": {item.name: [term.label for term in item.terms] for item in system.inputs},
        },
    }
    if kind == "aflc" and wish.like is None:
        data["controller"] = _with_room(data["controller"])
    return checked(Design, data, path, path.parent)


def _with_known_plant(name: str) -> Design:
    from hfc_design.files.pairing import load_design  # with JAX

    return load_design(name)


def _name(wish: Wish, path: Path) -> str:
    name = path.resolve().stem if wish.name is None else wish.name
    if not re.fullmatch(NAME, name):
        raise UserError(
            f"--name {name[:70]!r}: a design's name is letters, digits, . _ and -, 64 at most"
        )
    return name


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
    orders = [_order(item) for item in system.inputs]
    for i in orders[0]:
        for j in orders[1]:
            if (i, j) not in system.rules:
                one, other = (
                    f"{item.name} is {item.terms[k].label}"
                    for item, k in zip(system.inputs, (i, j), strict=True)
                )
                raise ValueError(f"there is no rule for {one} and {other}")
    table = [[system.rules[i, j][1] for j in orders[1]] for i in orders[0]]
    return table if row == 0 else [list(column) for column in zip(*table, strict=True)]


def _fuzzy(
    base: dict[str, Any], system: System, signals: tuple[str, str], plant: str
) -> dict[str, Any]:
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


def _with_room(controller: dict[str, Any]) -> dict[str, Any]:
    """An aflc; with overlaps of one step where they are too wide for its terms."""
    overlaps = controller["adaptation"]["smallest_overlap"]
    for key, overlap in overlaps.items():
        centres = [term["centre"] for term in controller[f"{key}_terms"]]
        if overlap > min(b - a for a, b in pairwise(centres)):
            adaptation = controller["adaptation"] | {"smallest_overlap": None}
            return controller | {"adaptation": adaptation}
    return controller


def _dumped(item: Input) -> list[dict[str, Any]]:
    return [term.model_dump() for term in triangle_records(item.terms)]


def _hierarchy(
    base: dict[str, Any], system: System, signals: tuple[str, str], plant: str
) -> dict[str, Any]:
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


def _flat_gaussians(terms: tuple[Term, ...]) -> list[dict[str, Any]]:
    """LL eq. 3 of each, in the shortest numbers that give what the file has bit for bit."""
    own = [term.label for term in terms]
    valid = all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,31}", label) for label in own)
    labels = own if valid else [f"f{k + 1}" for k in range(TERMS)]
    return [_eq_3(label, term) for label, term in zip(labels, terms, strict=True)]


def _eq_3(label: str, term: Term) -> dict[str, Any]:
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
    return {"label": label, "centre": centre, "half_width": half, "rate": rate}


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _order(item: Input) -> list[int]:
    """Indices of the terms, from the lowest to the highest."""
    return sorted(range(TERMS), key=lambda k: centre_of(item.terms[k]))
