"""What the page shows of a self-organising controller: its rules as it learns them."""

import numpy as np

from hfc_design.controllers import surfaces
from hfc_design.controllers.kind import Shown
from hfc_design.controllers.soc.law import HIGHEST, SETS, SocMemory, soc
from hfc_design.controllers.soc.pictures import surface, tables
from hfc_design.controllers.soc.record import SocDesign
from hfc_design.core.numbers import SCALARS, Floats
from hfc_design.pictures.section import Drawing, Listing, Section

#: The rules are drawn after these shares of the motion.
SHARES = (0.02, 0.25, 1.0)


def sections(record: SocDesign, shown: Shown) -> list[Section]:
    """Gains, the rules at the start, and what each axis has learnt by several moments."""
    units = shown.units
    text = (
        f"Every {1e3 * record.sample_time_s:g} ms the control reads the error of each axis and its "
        f"change since the last sample, both in {SETS} sets from -{HIGHEST} to {HIGHEST}. Of the "
        f"{SETS} × {SETS} rules four fire; each is then corrected by the error and its change."
    )
    gains = record.gains()._asdict()
    meanings = {
        "ge": ("sets per unit of the error", f"1/{units['error']}"),
        "gc": ("sets per unit of its change in a sample", f"1/{units['error']}"),
        "gu": ("command of a rule of 1", units["command"]),
        "gamma": ("share of the error that a correction removes", "1"),
        "xi": ("weight of the change in a correction", "1"),
    }
    rows = [[f"{key}, {text}", f"{gains[key]:.5g}", unit] for key, (text, unit) in meanings.items()]
    listing = Listing("Gains and steps.", ["parameter", "value", "unit"], rows)
    told = "Control surface to begin with, before it learns."
    begins = [_surface(record, shown, "rules to begin with", told)] if np.any(record.table) else []
    if not begins:
        text += " It begins with rules that say 0 everywhere."
    found = [Section("The controller", text, listing, begins)]
    if shown.signals:
        limits = shown.largest or (None,) * len(shown.signals)
        drawings: list[Drawing] = []
        for (axis, signals), limit in zip(named(shown).items(), limits, strict=True):
            drawings += _learning(record, shown, axis, learnt(record, signals, limit))
        text = "Each axis begins with the rules of the design and learns its own while it moves."
        found.append(Section("What it has learnt", text, None, drawings))
    return found


def _learning(
    record: SocDesign, shown: Shown, axis: str, rules: dict[float, Floats]
) -> list[Drawing]:
    """The rules of an axis by several moments, and the last of them with a cursor."""
    end = record.model_copy(update={"table": tuple(map(tuple, [*rules.values()][-1].tolist()))})
    told = f"Control surface of {axis} at the end of the motion, by the rules of then."
    return [
        Drawing(
            tables(rules, record.gains().gu, axis, shown.units["command"]),
            f"Heat maps of the rules that {axis} has learnt",
            f"Rules of {axis} as it learns them; rows by the error, columns by its change.",
        ),
        _surface(end, shown, f"rules of {axis} at the end", told),
    ]


def _surface(record: SocDesign, shown: Shown, title: str, told: str) -> Drawing:
    return surfaces.drawing(surface(record, shown.units, title), told)


def named(shown: Shown) -> dict[str, dict[str, Floats]]:
    """What each axis measured, by the axis' name for people."""
    several = len(shown.machine.axes) > 1
    signals = shown.signals or {}
    return {axis.upper() if several else "the axis": own for axis, own in signals.items()}


def learnt(
    record: SocDesign, signals: dict[str, Floats], limit: float | None
) -> dict[float, Floats]:
    """Time [s] -> the rules (11, 11) by then: of some moments, and of the end.

    Stepped over what the axis measured, some 0.1 ms a sample.
    """
    law, gains = soc(record.table, record.sample_time_s, limit), record.gains()
    memory: SocMemory = law.initial_memory(0.0)
    errors = signals["error"].tolist()
    moments = {max(round(share * len(errors)), 1) for share in SHARES}
    found: dict[float, Floats] = {}
    for count, error in enumerate(errors, 1):
        _, memory = law.step(SCALARS, gains, memory, {"error": error})
        if count in moments:
            found[count * record.sample_time_s] = np.array(memory.rules)
    return found
