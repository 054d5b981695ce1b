"""Facts of ``hfc show design``: the design's kind, its plant, its signals, its numbers."""

from collections.abc import Iterator

from hfc_design.controllers.controller import FOLLOWED
from hfc_design.controllers.controller import units_of as followed_too
from hfc_design.core.numbers import Json
from hfc_design.core.overrides import flat
from hfc_design.files.design import Design
from hfc_design.reference.entries import CONTROLLER, PLANT, in_units, parts, units_of


def facts(design: Design) -> Json:
    """Return the facts of a design: kind, plant, source, signals, fuzzy units of a tree, keys."""
    plant, record = design.plant, design.controller
    units = units_of(plant.name)
    signals = followed_too(units) if units else {}  # none for a user's plant that is not loaded
    meanings = FOLLOWED | {x.key.rpartition(".")[2]: x.meaning for x in parts(PLANT, plant.name)}
    reads = design.kind.reads(record) if design.kind.reads else []
    return {
        "name": design.name,
        "kind": record.kind,
        "summary": design.kind.summary,
        "plant": plant.name,
        "axes": [*plant.axes],
        "source": str(design.provenance.get("source", "")),
        "sample_time_s": record.sample_time_s,
        "limits": design.limits.model_dump(mode="json", exclude_none=True),
        "score": {key: x for key, x in design.score.items() if isinstance(x, str | float)},
        "signals": [
            {"name": name, "unit": signals.get(name, ""), "meaning": meanings.get(name, "")}
            for name in reads
        ],
        "units": [
            {key: unit[key] for key in ("id", "column_input", "row_input")}
            for unit in record.model_dump(mode="json").get("units", ())
        ],
        "keys": [*_keys(design, units, signals)],
    }


def _keys(design: Design, units: dict[str, str], signals: dict[str, str]) -> Iterator[Json]:
    """Yield the keys of the controller, with values, units and meanings."""
    known = {x.key: x for x in parts(CONTROLLER, design.controller.kind) if x.part == "design"}
    for key, value in flat(design.controller.model_dump(mode="json")).items():
        if key in ("kind", "sample_time_s") or value is None:
            continue
        table, _, name = key.rpartition(".")
        one = known.get(f"controller.{key}") or known.get(f"controller.{table}")
        of_signal = units | {"signal": signals.get(name, "signal")}
        unit, meaning = (in_units(one.unit, of_signal), one.meaning) if one else ("", "")
        yield {"key": key, "value": value, "unit": unit, "meaning": meaning}
