"""A controller as C99: a header and a source that do what ``runtime.Controller`` does."""

from itertools import pairwise
from pathlib import Path
from typing import Any

from hfc_design.controllers.aflc import law as aflc
from hfc_design.controllers.aflc.adaptation import ALIKE, PERFORMANCE, ZR, blamed_aflc, blamed_soflc
from hfc_design.controllers.flc.law import MM_PER_BLU, SCALARS, STANDSTILL
from hfc_design.controllers.flc.record import AflcDesign, FlcDesign, PidDesign, SoflcDesign
from hfc_design.controllers.hierarchical import root as root_unit
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, HierarchicalDesign, PdDesign
from hfc_design.formats.c_lookup import lookup
from hfc_design.formats.units import UNITS, built_in, comment, facts, identifier, rule_units
from hfc_design.formats.writing import rendered, write_folder
from hfc_design.runtime import PREVIOUS

SIGNAL_UNITS = {
    "error_rate": "rad/s",
    "deflection": "rad",
    "deflection_rate": "rad/s",
    "spindle_velocity": "rad/s",
    "velocity": "BLU/s",
}
#: Words that no member of a struct can be called.
KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long register restrict return short signed sizeof static struct switch typedef "
    "union unsigned void volatile while asm bool catch class delete explicit export false friend "
    "linux mutable namespace new operator private protected public template this throw true try "
    "typeid typename typeof unix using virtual"
)


def write(design: Design, path: Path) -> None:
    """Write the folder ``path`` with ``NAME.h`` and ``NAME.c``, NAME as ``c_name`` gives it.

    Raises:
        UserError: an input is called like a word of the language.
        RunError: the folder cannot be written.
    """
    _write(design, path, _parts(design))


def write_lookup(design: Design, path: Path, points: int) -> str:
    """The same without ``exp``: degrees tabulated at ``points`` values, linear in between.

    Returns:
        The largest deviation from the exact command that was found, with the command's unit.

    Raises:
        UserError: the controller has no terms with an exponential; or as ``write``.
        RunError: the folder cannot be written.
    """
    controller = design.controller
    if not isinstance(controller, HierarchicalDesign):
        raise UserError(
            f"--lookup: design {design.name} is of kind {controller.kind}: nothing to tabulate, "
            "its C code needs no exp"
        )
    found = lookup(controller, points)
    _write(design, path, _parts(design) | {"lookup": found, "exponential": False})
    return f"{found.deviation:.2g} {_command_unit(design)}"


def c_name(design: Design) -> str:
    """What every name in the C code of a design begins with."""
    name = identifier(design.name)
    return name if name[:1].isalpha() else f"hfc_{name}"


def signals(design: Design) -> dict[str, str]:
    """What the controller reads at a sample, and its unit where that is known."""
    controller, names = built_in(design), ["error"]
    if isinstance(controller, PdDesign | HierarchicalDesign):
        names.append("error_rate")
    if isinstance(controller, HierarchicalDesign):
        names += [item.name.removeprefix(PREVIOUS) for item in controller.inputs]
    elif not isinstance(controller, PdDesign | PidDesign) and controller.low_velocity:
        names.append("velocity")
    for name in names:
        if name in KEYWORDS.split() or name.startswith("_"):
            raise UserError(f"design {design.name}: an input named {name} cannot be one in C")
    units = SIGNAL_UNITS | {"error": UNITS.get(design.plant.name, ("",))[0]}
    return {identifier(name): units.get(name, "") for name in names}


def _write(design: Design, path: Path, parts: dict[str, Any]) -> None:
    name = c_name(design)
    values = {
        "name": name,
        "head": comment(facts(design)),
        "signals": signals(design),
        "command_unit": _command_unit(design),
        "every": design.controller.sample_time_s,
        "alike": ALIKE,
        "performance": PERFORMANCE,
        **parts,
    }
    templates = {"h": "c/header.h.j2", "c": "c/source.c.j2"}
    texts = {f"{name}.{end}": rendered(file, design, **values) for end, file in templates.items()}
    write_folder(path, texts)


def _command_unit(design: Design) -> str:
    return UNITS.get(design.plant.name, ("", "unit"))[1]


def _parts(design: Design) -> dict[str, Any]:
    """What the templates of the design's kind need; ``part`` is the template's name."""
    controller = built_in(design)
    if isinstance(controller, PdDesign):
        return {"part": "pd", "pd": controller.pd, "exponential": False}
    if isinstance(controller, PidDesign):
        return {"part": "pid", "gains": controller.gains(), "exponential": False}
    if isinstance(controller, HierarchicalDesign):
        return _hierarchical(design, controller)
    return _fuzzy(controller)


def _hierarchical(design: Design, controller: HierarchicalDesign) -> dict[str, Any]:
    inputs, previous = [], []
    for item in controller.inputs:
        read = "inputs->" + identifier(item.name)
        if item.name.startswith(PREVIOUS):
            previous.append(identifier(item.name.removeprefix(PREVIOUS)))
            read = "state->previous_" + previous[-1]
        inputs.append({"scale": item.scale, "read": read})
    adaptation = controller.adaptation
    scales = {item.name: item.scale for item in controller.inputs}
    return {
        "part": "hierarchical",
        "exponential": True,
        "lookup": None,
        "pd": controller.pd,
        "inputs": inputs,
        "previous": previous,
        "terms": controller.terms,
        "units": [
            unit._asdict() | {"sources": sources}
            for unit, sources in zip(rule_units(design), controller.sources(), strict=True)
        ],
        "output_scale": controller.output_scale,
        "adaptation": adaptation
        and {
            "k_c": adaptation.k_c,
            "largest_move": adaptation.largest_move,
            "error_scale": adaptation.error_scale or scales["error"],
        },
        "fired": root_unit.FIRED,
    }


def _fuzzy(controller: FlcDesign | AflcDesign | SoflcDesign) -> dict[str, Any]:
    """An adaptive controller starts from what its law makes of the design at the first sample."""
    gains = controller.table()
    error_terms, change_terms, table = gains.error_terms, gains.change_terms, gains.singletons
    adaptive: dict[str, Any] = {"adaptive": False, "start": "", "current": ""}
    if not isinstance(controller, FlcDesign):
        start = controller.gains()
        blamed = blamed_aflc if isinstance(controller, AflcDesign) else blamed_soflc
        error_terms, change_terms, table = aflc.adapted(
            SCALARS, blamed, start, aflc.initial_memory(0.0), 0.0
        )
        adaptive = {"adaptive": True, "start": "start_", "current": "state->"}
        adaptive |= {"rates": start.rates, "sectors": start.sectors}
        adaptive["positive"] = [
            [int(u >= 0.0 if i > ZR else u > 0.0) for u in row]
            for i, row in enumerate(gains.singletons)
        ]
    return adaptive | {
        "part": "fuzzy",
        "exponential": False,
        "form": controller.form if isinstance(controller, FlcDesign) else "PD",
        "error_centres": [term[1] for term in error_terms],
        "change_centres": [term[1] for term in change_terms],
        "error_joints": [(lower[2], upper[0]) for lower, upper in pairwise(error_terms)],
        "change_joints": [(lower[2], upper[0]) for lower, upper in pairwise(change_terms)],
        "table": table,
        "integral": gains.k_i * controller.sample_time_s,
        "compensation": gains.compensation,
        "mm_per_blu": MM_PER_BLU,
        "standstill": STANDSTILL,
    }
