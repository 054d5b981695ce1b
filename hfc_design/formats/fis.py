"""Fuzzy Inference Systems of MATLAB and of Octave's fuzzy-logic-toolkit, and what runs them."""

from itertools import pairwise

from hfc_design.controllers.rules import FlatGaussian
from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.fuzzy_files import Input, beside, inputs, texts, unit_head
from hfc_design.formats.writing import Format, matlab_name, rendered, rule_units, signal_units

#: exp(-700) is about the smallest number of full precision.
FADED = 700.0


def systems(design: Design) -> dict[str, str]:
    """A folder with one ``.fis`` a unit and ``controller.m``, which evaluates them all.

    A hierarchy also gets ``controller_tree.m``, which builds MATLAB's ``fistree``.

    Raises:
        UserError: a name is none of MATLAB, or there are inputs for which no rule fires.
    """
    files, units, about = texts(design, "fis"), rule_units(design), beside(design)
    sides = inputs(units)
    for name, pair in sides.items():
        # Where no rule fires a unit gives 0, Octave's evalfis an error, MATLAB's another value.
        if sum(map(_faintest, pair)) > FADED:
            raise UserError(
                f"--to fis: the terms of {name} leave gaps in which no rule fires, and the "
                "programs that read the format have no common value for these"
            )
    signals, remembered = _signals(design, about)
    fields = ", ".join(f"{matlab_name('fis', name)} [{unit}]" for name, unit in signals.items())
    values: dict[str, object] = {"units": units, "head": unit_head(design), "about": about}
    values |= {"sides": sides, "fields": fields, "remembered": remembered}
    files["controller.m"] = rendered("controller.m.j2", design, **values)
    wires = [(name, unit.name) for unit in units for name in (unit.row, unit.column)]
    if wires := [wire for wire in wires if wire[0] in sides]:
        files["controller_tree.m"] = rendered("controller_tree.m.j2", design, wires=wires, **values)
    return files


def _faintest(side: Input) -> float:
    """-ln of the lowest that the highest degree of an input can be (LL eq. 3)."""
    terms = [term for term in side.terms if isinstance(term, FlatGaussian)]
    if not terms:
        return 0.0  # triangles leave no gap, see flc.record
    ends = (edge for term in terms for edge in (term.low, term.high))
    marks = sorted({side.lowest, side.highest, *ends})
    middles = [0.5 * (a + b) for a, b in pairwise(marks)]
    return max(min(_exponent(term, u) for term in terms) for u in [*marks, *middles])


def _exponent(term: FlatGaussian, u: float) -> float:
    return 0.5 * (max(term.low - u, u - term.high, 0.0) / term.sigma) ** 2


def _signals(design: Design, about: Json) -> tuple[dict[str, str], list[str]]:
    """Signals that the command takes with their units, and what is remembered."""
    if "inputs" not in about:
        low = {"velocity": "BLU/s"} if about["low_velocity"] else {}
        return {"error": "BLU"} | low, ["error", "action", "integral"]
    units = signal_units(design)
    names = ["error", "error_rate", *(item["signal"] for item in about["inputs"])]
    earlier = {item["signal"] for item in about["inputs"] if item["samples_ago"]}
    return {name: units.get(name, "") for name in names}, sorted(earlier)


TEXT = "a folder for MATLAB and Octave, one .fis a unit, and controller.m"
FORMATS = (Format("fis", TEXT, systems),)
