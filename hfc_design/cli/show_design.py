"""What ``hfc show design`` says: what it is, for which plant, what it reads, its numbers."""

from typing import Any

from hfc_design.cli.show_tables import columns, told
from hfc_design.controllers.controller import FOLLOWED
from hfc_design.controllers.controller import units_of as followed_too
from hfc_design.core.console import terminal
from hfc_design.core.dotted import flat
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.reference.entries import CONTROLLER, PLANT, in_units, parts, units_of


def facts(design: Design) -> Json:
    """A design in words and numbers: kind, plant, source, signals, units of a tree, keys."""
    plant, record = design.plant, design.controller
    units = units_of(plant.name)
    own = {one.key.rpartition(".")[2]: one.meaning for one in parts(PLANT, plant.name)}
    meanings = {**FOLLOWED, **own}
    read = followed_too(units) if units else {}  # of an own plant that is not known here: none
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
            {"name": name, "unit": read.get(name, ""), "meaning": meanings.get(name, "")}
            for name in reads
        ],
        "units": [
            {key: unit[key] for key in ("id", "column_input", "row_input")}
            for unit in record.model_dump(mode="json").get("units", ())
        ],
        "keys": _keys(design, units),
    }


def _keys(design: Design, units: dict[str, str]) -> list[Json]:
    """What stands in the controller, with units and meanings."""
    known = {x.key: x for x in parts(CONTROLLER, design.controller.kind) if x.part == "design"}
    signals = followed_too(units) if units else {}
    found = []
    for key, value in flat(design.controller.model_dump(mode="json")).items():
        table, _, name = key.rpartition(".")
        one = known.get(f"controller.{key}") or known.get(f"controller.{table}")
        if key in ("kind", "sample_time_s") or value is None:
            continue
        of_signal = units | {"signal": signals.get(name, "signal")}
        unit, meaning = (in_units(one.unit, of_signal), one.meaning) if one else ("", "")
        found.append({"key": key, "value": value, "unit": unit, "meaning": meaning})
    return found


def show_design(found: Json) -> None:
    """The same on a terminal."""
    out = terminal()

    def line(text: str) -> None:
        out.print(text, highlight=False)

    axes = f", axes {', '.join(found['axes'])}" if found["axes"] else ""
    line(f"design {found['name']}: {found['kind']}, {found['summary']}")
    line(f"for the plant {found['plant']}{axes}, every {found['sample_time_s']:g} s")
    if found["source"]:
        line(f"source: {found['source']}")
    if limits := flat(found["limits"]):
        line("limits: " + ", ".join(f"{key} {told(x)}" for key, x in limits.items() if x))
    if found["score"]:
        line("score: " + ", ".join(f"{key} {told(x)}" for key, x in found["score"].items()))
    if found["signals"]:
        _rows(
            "signals that it reads",
            ("signal", "unit", "meaning"),
            [(one["name"], one["unit"], one["meaning"]) for one in found["signals"]],
        )
    if found["units"]:
        tree = [(f"unit-{x['id']}", x["column_input"], x["row_input"]) for x in found["units"]]
        _rows("fuzzy units, the root last", ("unit", "columns", "rows"), tree)
    keys = [(x["key"], told(x["value"], x["unit"]), x["meaning"]) for x in found["keys"]]
    _rows("controller", ("key", "value", "meaning"), keys)


def _rows(title: str, names: tuple[str, ...], rows: list[Any]) -> None:
    table = columns(title, *names)
    for row in rows:
        table.add_row(*row)
    terminal().print()
    terminal().print(table)
