"""A hierarchy in C and in Structured Text."""

from pathlib import Path

from hfc_design.controllers.aflc import ADAPTATION
from hfc_design.controllers.aflc.adaptation import ALIKE, PERFORMANCE
from hfc_design.controllers.hierarchical.law import PREVIOUS
from hfc_design.controllers.hierarchical.record import HierarchicalDesign
from hfc_design.controllers.hierarchical.root import FIRED
from hfc_design.controllers.hierarchical.rules import units
from hfc_design.controllers.kind import Template
from hfc_design.controllers.rules import identifier
from hfc_design.core.shapes import Json

HERE = Path(__file__).parent / "templates"


def _c(record: HierarchicalDesign) -> Json:
    inputs, previous = [], []
    for item in record.inputs:
        read = "inputs->" + identifier(item.name)
        if item.name.startswith(PREVIOUS):
            previous.append(identifier(item.name.removeprefix(PREVIOUS)))
            read = "state->previous_" + previous[-1]
        inputs.append({"scale": item.scale, "read": read})
    adaptation = record.adaptation
    scales = {item.name: item.scale for item in record.inputs}
    return {
        "exponential": True,
        "lookup": None,
        "pd": record.pd,
        "inputs": inputs,
        "previous": previous,
        "terms": record.terms,
        "units": [
            unit._asdict() | {"sources": sources}
            for unit, sources in zip(units(record), record.sources(), strict=True)
        ],
        "output_scale": record.output_scale,
        "adaptation": adaptation
        and {
            "k_c": adaptation.k_c,
            "largest_move": adaptation.largest_move,
            "error_scale": adaptation.error_scale or scales["error"],
        },
        "fired": FIRED,
        "alike": ALIKE,
        "performance": PERFORMANCE,
    }


def _st(record: HierarchicalDesign) -> Json:
    names = [identifier(item.name) for item in record.inputs]
    scales = {f"scale_{n}": item.scale for n, item in zip(names, record.inputs, strict=True)}
    terms = {
        f"term_{key}": [getattr(term, key) for term in record.terms]
        for key in ("centre", "half_width", "rate")
    }
    gains = {"kp": record.pd.kp, "kd": record.pd.kd, "output_scale": record.output_scale}
    own = units(record)
    units_named = {unit.name for unit in own}
    return {
        "constants": gains | scales | terms,
        "remembered": [name for name in names if name.startswith(PREVIOUS)],
        "within": ["distance", *(f"scaled_{n}" for n in names)],
        "units": own,
        "inputs": names,
        "leaves_out": record.adaptation is not None,
        "scaled": lambda source: source if source in units_named else f"scaled_{source}",
    }


C = Template((HERE, *ADAPTATION), _c)
ST = Template((HERE,), _st)
