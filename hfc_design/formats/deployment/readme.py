"""README page of a design: connections, origin, score, behaviour on faults, and how to check it."""

import re
from contextlib import suppress
from typing import Any, NamedTuple

from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.core.tables import Table
from hfc_design.core.wording import percent
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import axes_of
from hfc_design.formats import saving
from hfc_design.formats.deployment.signal_conditioning import scene
from hfc_design.formats.deployment.vectors import Vectors, unused
from hfc_design.formats.writing import each_axis, plain, signal_meanings, signal_units
from hfc_design.simulation.acceptance import ENOUGH, missed_text
from hfc_design.simulation.usable_tables import stress_table


class Signal(NamedTuple):
    """Row of the table of signals to connect."""

    name: str
    axes: str  # names of the axes that have it; "": all
    unit: str
    meaning: str
    tested: str  # largest magnitude in the vectors; NOT_USED if no command depends on it


class Measure(NamedTuple):
    """Row of the score: a metric for the motion or axis where it is largest."""

    name: str
    value: str
    where: str  # motion or axis; "" if the score names none


#: Keys of a score that matter at the machine: errors, and peak values of the drive.
MEASURES = re.compile(r"(?:(?P<where>\w+?)_)?(?P<name>(?:rms|max)_(?:\w+_)?error\w*|peak_\w+)")
#: Remark on a signal that no command depends on, because its gains are 0.
NOT_USED = "not used, gain 0"
#: Keys that ``usable`` in a score needs to be described.
KEPT = ("share", "machines", "spread")
#: Verdict other than yes -> first words of the line on it.
NOT = {
    "no": "**not usable as it is**: ",
    "on this model only": "**usable on this model only**, not under stress: ",
}


def values(design: Design, vectors: Vectors) -> Json:
    """Return the values for the templates of the README page."""
    axes = vectors.axes if vectors.axes != ("",) else ()
    rows: Json = {"signals": _signals(design, list(vectors.signals), axes, vectors)}
    rows["commands"] = _signals(design, ["command"], axes, vectors)
    others = {"axes": vectors.axes, "path": vectors.path, "vectors": vectors}
    return known(design, axes) | rows | others


def known(design: Design, axes: tuple[str, ...]) -> Json:
    """Return facts on a design for any page; ``axes`` are those of a machine, () for one axis."""
    record = design.controller
    read = design.kind.reads(record) if design.kind.reads else []
    limited = axes or (design.axis,)
    facts: Json = {"design": design, "kind": design.kind.name, "about": origin(design)}
    facts |= {"scene": scene(design, read), "learns": saving.learns(design)}
    facts |= {"connection": design.connected, "connecting": _connecting(design)}
    facts["limits"] = {axis: design.limits.of(axis).command for axis in limited}
    return facts | {"changes": design.changes(limited)}


class Origin(NamedTuple):
    """Origin and score of a design; "" or None stand for what is not known."""

    source: str
    scored_on: str  # name of the scenario
    score: list[Measure]
    chaotic: bool
    usable: str  # whether the design is usable, in words
    stress: Table | None  # merit under each stress


def origin(design: Design) -> Origin:
    """Return the origin and the score of a design."""
    score, source = design.score, plain(str(design.provenance.get("source", "")))
    sampled: Any = design.provenance.get("sampled")
    with suppress(KeyError, TypeError, ValueError, ZeroDivisionError):  # missing, or edited by hand
        (low, high), off = sampled["output_range"], float(sampled["largest_deviation"])
        source += f"; a table sampled from it, deviating by at most {off:.3g}"
        source += f", {percent(off / (high - low))} of the range of its output"
    scenario, used = plain(str(score.get("scenario", ""))), score.get("usable")
    chaotic = score.get("chaotic") is True
    return Origin(source, scenario, measures(score), chaotic, _usable(used), _stress(used))


def _signals(
    design: Design, names: list[str], axes: tuple[str, ...], vectors: Vectors
) -> list[Signal]:
    """Return a row for each signal; axes where its unit or meaning differs have separate rows."""
    idle = {*map(identifier, unused(design, vectors) if "command" not in names else ())}
    each = {"": (signal_units(design), signal_meanings(design))}
    if axes:
        each = each_axis(design)
    rows: dict[tuple[str, str, str], list[str]] = {}
    largest: dict[tuple[str, str, str], float] = {}
    for of, (units, meanings) in each.items():
        of_axes = (of,) if of else vectors.axes
        for name in names:
            row = identifier(name), plain(units.get(name, "")), plain(meanings.get(name, ""))
            rows.setdefault(row, []).append(of)
            sizes = (vectors.largest(axis, name) for axis in of_axes)
            largest[row] = max(largest.get(row, 0.0), *sizes)
    texts = {row: NOT_USED if row[0] in idle else f"{x:.3g}" for row, x in largest.items()}
    order = rows if "" in each else sorted(rows)
    return [Signal(row[0], ", ".join(rows[row]), *row[1:], texts[row]) for row in order]


def _connecting(design: Design) -> list[str]:
    """Return the connection notes of the kind and of every controller inside it, each note once."""
    record = design.controller
    lines = list(record.connecting())
    axes = axes_of(design) if design.kind.controller else ()
    for inner in record.inside(axes).values():
        lines += inner.connecting()
    return list(dict.fromkeys(lines))


def measures(score: Json) -> list[Measure]:
    """Return the metrics of a score that matter at the machine, with the largest value of each."""
    largest: dict[str, tuple[float, str]] = {}
    for key, value in score.items():
        named = MEASURES.fullmatch(key)
        if named and isinstance(value, int | float) and not isinstance(value, bool):
            before = largest.get(named["name"], (0.0, ""))[0]
            if named["name"] not in largest or abs(value) > abs(before):
                largest[named["name"]] = float(value), named["where"] or ""
    return [Measure(name, f"{value:.3g}", of) for name, (value, of) in largest.items()]


def _usable(stored: object) -> str:
    """Return as text if a design is usable, and how many machines passed; "" if not stored."""
    if not isinstance(stored, dict):
        return ""
    numbers = [x for key in KEPT if isinstance(x := stored.get(key), int | float)]
    if len(numbers) < len(KEPT):
        return ""
    share, machines, spread = map(float, numbers)
    off = f"with parameters within {100.0 * spread:.3g} %"
    passing = f"{100.0 * share:.3g} % of {machines:.0f} machines {off}"
    verdict = stored.get("verdict", "yes" if share >= ENOUGH else "no")
    said = "usable on" if verdict == "yes" else f"{NOT.get(verdict, '')}passes on"
    passing = f"{said} {passing}"
    with suppress(KeyError, TypeError, AttributeError, ValueError):  # edited by hand
        if missed := missed_text(stored.get("missed", {})):
            passing += f"; {plain(missed)}"
    return passing


def _stress(stored: Any) -> Table | None:
    """Return the table of the design's behaviour under stress; None if it is not stored."""
    with suppress(KeyError, TypeError, AttributeError, ValueError):  # edited by hand
        return stress_table(stored["stress"]) if stored["stress"] else None
    return None
