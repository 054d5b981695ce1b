"""Construction of a design from the system in a file and from the options of the user."""

import re
import shlex
from collections.abc import Callable, Sequence
from itertools import pairwise, product
from math import inf, sqrt
from pathlib import Path
from typing import NamedTuple

from hfc_design.controllers.flc.record import USUAL
from hfc_design.controllers.hierarchical.record import input_names
from hfc_design.controllers.rules import numbered, range_of, spread
from hfc_design.core.numbers import Json
from hfc_design.core.records import NAME, UserError, checked, either, option
from hfc_design.core.wording import alternatives
from hfc_design.files.design import Design, named_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.machine import PlantSettings
from hfc_design.formats.reading.system import Input, Output, Shape, Singleton, System, identifiers

VARIABLES = ("error", "error_change", "output")
HIERARCHY = "pd+hierarchical-fuzzy"
#: Kind -> plant if neither --plant nor --like names one.
PLANT_OF = {"flc": "feed-drive", "aflc": "feed-drive", HIERARCHY: "c-axis"}
#: Number of changed names that are listed.
NAMED = 3
SAMPLE_TIMES = {"feed-drive": 0.01, "c-axis": 0.001}  # by plant, if not given [s]
#: Design from which an aflc takes its adaptation if --like is not given.
ADAPTIVE = "jee-koren-2004-aflc"


class Wish(NamedTuple):
    """Options of the user for an import."""

    kind: str | None = None
    name: str | None = None
    plant: str | None = None
    sample_time: float | None = None  # [s]
    like: str | None = None  # design with everything that the file does not contain
    signals: dict[str, str] = {}  # name of an input in the file -> the signal that it is
    terms: tuple[int, int] | None = None  # number of terms of each input, for sampling
    axis: str | None = None  # axis whose learned numbers the file contains
    output: str | None = None  # name of the output to import, if the file has several


def design_of(
    system: System, wish: Wish, path: Path, digests: dict[str, str], sampled: Json
) -> Design:
    """Return the design; ``digests`` of the files and the report ``sampled`` go to its provenance.

    Raises:
        UserError, ValueError: the options of the user, or the contents of the file, do not fit.
    """
    gaussian, other = (item.terms[0].gaussian for item in system.inputs)
    if gaussian != other:
        raise ValueError("both inputs must have terms of one shape (got Gaussian and straight)")
    like = None if wish.like is None else load_design(wish.like)
    kind = wish.kind or (like.controller.kind if like else HIERARCHY if gaussian else "flc")
    if kind not in PLANT_OF or (like and like.controller.kind != kind):
        listed = alternatives(PLANT_OF) if wish.kind is None else kind
        raise UserError(f"{option('like', wish.like)}: must be of kind {listed}")
    if (kind == HIERARCHY) != gaussian:
        needed = "Gaussian terms" if kind == HIERARCHY else "triangles"
        raise ValueError(f"kind {kind} needs {needed}, but the file has others")
    if kind == "aflc" and like is None:
        like = named_design(ADAPTIVE)
    plant_name = wish.plant or (like.plant.name if like else PLANT_OF[kind])
    plant = {"name": plant_name, "parameters": {}}
    base = {"kind": kind, "sample_time_s": SAMPLE_TIMES.get(plant_name)}
    if like:
        plant = like.plant.model_dump() if like.plant.name == plant_name else plant
        base |= like.controller.model_dump()
    if wish.sample_time is not None:
        base["sample_time_s"] = wish.sample_time
    if base["sample_time_s"] is None:
        raise UserError(f"{option('sample_time')}: must be given for the plant {plant_name}")
    name = checked_name(path.resolve().stem if wish.name is None else wish.name)
    make, known = _fuzzy, ["error", "error_change"]
    if kind == HIERARCHY:
        make = _hierarchy
        known = input_names(PlantSettings(name=plant_name).machine.drives[0].inputs)
    controller = make(base, system, _signals(system, wish, known))
    if kind == "aflc" and wish.like is None:
        controller = _with_room(controller)
    origin = {"source": f"imported from {path.name}", "sha256": digests}
    origin["terms"] = _originals(system)
    names = {} if gaussian else _renamed(system)
    more = {"names": names, "notes": [*system.notes], "sampled": sampled}
    origin |= {key: value for key, value in more.items() if value}
    data = {"name": name, "plant": plant, "controller": controller, "provenance": origin}
    return checked(Design, data, path, path.parent)


def assumptions_text(provenance: Json) -> list[str]:
    """Return lines for the user: notes on the file, and names that were changed."""
    names = [f"{old[:40]} is {new}" for new, old in provenance.get("names", {}).items()]
    more = f" and {len(names) - NAMED} more, see provenance.names" if len(names) > NAMED else ""
    line = f"renamed, as names must be identifiers: {', '.join(names[:NAMED])}{more}"
    return [*provenance.get("notes", []), *([line] if names else [])]


def assumed(wish: Wish, design: Design) -> str:
    """Return a line on the plant and the sample time that were assumed; "" if both were given."""
    if wish.like is not None:
        return ""
    assumptions = {}
    if wish.plant is None:
        assumptions["--plant"] = f"plant {design.plant.name}"
    if wish.sample_time is None:
        assumptions["--sample-time"] = f"sample time {design.controller.sample_time_s:g} s"
    line = f"{', '.join(assumptions.values())} assumed: {', '.join(assumptions)}"
    return line if assumptions else ""


def checked_name(name: str) -> str:
    """Return ``name`` if a design may have it; UserError otherwise."""
    if not re.fullmatch(NAME, name):
        message = "must be at most 64 letters, digits, '.', '_' and '-'"
        shown = repr(name[:70])
        raise UserError(f"{either(f'--name {shown}', f'name={shown}')}: {message}")
    return name


def _signals(system: System, wish: Wish, known: list[str]) -> tuple[str, str]:
    """Return the signals of both inputs; UserError, ValueError: one is missing or unknown."""
    if system.signals is not None:
        return system.signals
    names = [item.name.text for item in system.inputs]
    for name in wish.signals:
        if name not in names:
            given = option("signal", argument="signals", key=name)
            raise UserError(f"{given}: unknown input; available: {', '.join(names)}")
    first, second = (wish.signals.get(name, name) for name in names)
    if first == second:
        raise ValueError(f"the inputs must be different signals (got {first!r} twice)")
    sides = zip(system.inputs, (first, second), (second, first), strict=True)
    for item, signal, other in sides:
        if signal not in known:
            name = item.name.text
            free = [each for each in known if each != other]
            shown = name or "NAME"
            typed = shlex.quote(f"{shown}={free[0]}")
            example = either(f"--signal {typed}", f"signals={ {shown: free[0]} }")
            needed = f"needs its signal, as in {example}; available: {', '.join(free)}"
            raise item.name.fault(f"input {name!r}: {needed}")
    return first, second


def _originals(system: System) -> Json:
    """Return variable -> names of its terms, both as in the file."""
    labels = {item.name.text: item.labels for item in system.inputs}
    if system.output.labels:
        labels[system.output.name] = list(system.output.labels)
    return labels


def _variables(system: System) -> list[str]:
    """Return the identifiers of both inputs, in the order of the file, and of the output."""
    names = [*(item.name.text for item in system.inputs), system.output.name or USUAL.output]
    return identifiers(names, "variable", ("input_1", "input_2", "output"))


def _renamed(system: System) -> dict[str, str]:
    """Return name in the design ("input.term" of a term) -> name in the file, if different."""
    called = _variables(system)
    names = [*(item.name.text for item in system.inputs), system.output.name or called[2]]
    pairs = [*zip(called, names, strict=True)]
    for item, called_here in zip(system.inputs, called, strict=False):
        labels = [item.labels[k] for k in item.order]
        terms = identifiers(labels, "term")
        pairs += [(f"{called_here}.{new}", old) for new, old in zip(terms, labels, strict=True)]
    return {new: old for new, old in pairs if new.rpartition(".")[2] != old}


def _table(system: System) -> list[list[Singleton]]:
    """Return the singletons [term of first input][of second], from the lowest term on."""
    first, second = system.inputs
    for i, j in product(first.order, second.order):
        if (i, j) not in system.rules:
            one = f"{first.name.text} is {first.labels[i]}"
            raise ValueError(f"no rule for {one} and {second.name.text} is {second.labels[j]}")
    return [[system.rules[i, j][1] for j in second.order] for i in first.order]


def _fuzzy(base: Json, system: System, signals: tuple[str, str]) -> Json:
    """Return the controller of kind flc or aflc."""
    table, (error, change) = _table(system), system.inputs
    if signals[0] != "error":
        table, error, change = [list(column) for column in zip(*table, strict=True)], change, error
    *inputs, output = _variables(system)
    if signals[0] != "error":
        inputs.reverse()
    called = dict(zip(VARIABLES, (*inputs, output), strict=True))
    (engine,) = identifiers([system.name or called["output"]], "engine")
    if engine != called["output"]:  # if equal, the system has no own name
        called["engine"] = engine
    fields: Json = {"error_terms": error.triangles, "error_change_terms": change.triangles}
    fields |= {"rules": _rules(table), "names": called}
    fields["ranges"] = _ranges(error, change, system.output, table)
    return {"integral_gain": 0.0, **base, **fields}


def _ranges(error: Input, change: Input, output: Output, table: list[list[Singleton]]) -> Json:
    """Return variable -> range in the file, if finite and different from that of an export."""
    usual = [range_of([term.edges() for term in item.triangles]) for item in (error, change)]
    usual.append(spread([[one.value for one in row] for row in table]))
    ends_of = [(item.low, item.high) for item in (error, change, output)]
    return {
        name: ends
        for name, ends, usual_ends in zip(VARIABLES, ends_of, usual, strict=True)
        if -inf < ends[0] < ends[1] < inf and ends != usual_ends
    }


def _rules(table: list[list[Singleton]]) -> Json:
    """Return the rule table, with names of singletons if every name has only one number."""
    centroids = [[one.value for one in row] for row in table]
    values = {one.label: one.value for row in table for one in row}
    nameless = "" in values or all(
        one.label == numbered(i, j) for i, row in enumerate(table) for j, one in enumerate(row)
    )
    if nameless or any(values[one.label] != one.value for row in table for one in row):
        return {"centroids": centroids}
    called = dict(zip(values, identifiers(values, "term"), strict=True))
    labels = [[called[one.label] for one in row] for row in table]
    terms = {called[label]: value for label, value in values.items()}
    return {"labels": labels, "centroids": centroids, "output_terms": terms}


def _with_room(controller: Json) -> Json:
    """Return an aflc; its smallest overlap becomes one step if it is too wide for its terms."""
    adaptation = controller["adaptation"]
    for key, overlap in adaptation["smallest_overlap"].items():
        centres = [term.centre for term in controller[f"{key}_terms"]]
        if overlap > min(b - a for a, b in pairwise(centres)):
            return controller | {"adaptation": adaptation | {"smallest_overlap": None}}
    return controller


def _hierarchy(base: Json, system: System, signals: tuple[str, str]) -> Json:
    """Return a hierarchy of one unit; without --like its PD gains are 0, all its scales 1."""
    first, second = system.inputs
    for item in system.inputs:
        if item.low < -1.0 or item.high > 1.0:
            raise item.name.fault(f"input {item.name.text}: its range must be between -1 and 1")
    if [term[1:] for term in first.terms] != [term[1:] for term in second.terms]:
        raise ValueError("both inputs must have the same terms in a hierarchy")
    scales = {item["name"]: item["scale"] for item in base.get("inputs", ())}
    row, column = signals
    table = [[one.value for one in values] for values in _table(system)]
    unit = {"id": 0, "column_input": column, "row_input": row, "consequents": table}
    inputs = [{"name": name, "scale": scales.get(name, 1.0)} for name in (column, row)]
    fields: Json = {"inputs": inputs, "terms": _flat_gaussians(first.terms), "units": [unit]}
    return {"pd": {"kp": 0.0, "kd": 0.0}, "output_scale": 1.0, **base, **fields}


def _flat_gaussians(terms: Sequence[Shape]) -> list[Json]:
    """Return the records of terms (LL eq. 3), in the shortest numbers equal to the file's."""
    labels = identifiers([term.label.text for term in terms], "term")
    records = []
    for label, (_, _, sigma, low, high, _) in zip(labels, terms, strict=True):
        middle = (0.5 * (low + high), 0.5 * (high - low))
        centre, half = _shortest(middle, lambda c, h: (c - h, c + h), (low, high))
        (rate,) = _shortest((0.5 / sigma**2,), lambda rate: 1.0 / sqrt(2.0 * rate), sigma)
        records.append({"label": label, "centre": centre, "half_width": half, "rate": rate})
    return records


def _shortest(
    values: tuple[float, ...], back: Callable[..., object], wanted: object
) -> list[float]:
    """Return ``values`` in the fewest digits from which ``back`` computes ``wanted``."""
    rounded = list(values)
    for digits in range(1, 18):  # 17 digits restore every float
        rounded = [float(f"{value:.{digits}g}") for value in values]
        if back(*rounded) == wanted:
            break
    return rounded
