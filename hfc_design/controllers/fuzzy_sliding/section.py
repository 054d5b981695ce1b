"""What the page shows of adaptive fuzzy sliding control: surface, rules, what they learn."""

from typing import NamedTuple

import numpy as np

from hfc_design.controllers import surfaces
from hfc_design.controllers.fuzzy_sliding.law import sliding
from hfc_design.controllers.fuzzy_sliding.pictures import over_time, phase_plane, rules, surface
from hfc_design.controllers.fuzzy_sliding.record import SlidingDesign
from hfc_design.controllers.kind import Shown
from hfc_design.core.numbers import SCALARS, Floats
from hfc_design.pictures.section import Drawing, Listing, Section

ABOUT = (
    "The command is what the rules conclude from the error and its rate, and a part that pushes "
    "towards the surface s = de/dt + λe, in proportion to s within the boundary layer (Lin & Gai "
    "2009, eq. 9 to 13). Each rule that fires moves by its share of the judgement, the last column "
    "of P with the error (eq. 14), and stays within its largest move."
)


class Learning(NamedTuple):
    """An axis during the motion."""

    error: Floats  # (steps,)
    rate: Floats  # (steps,)
    moves: Floats  # (steps, 7, 7) of the consequents from where they were designed


def sections(record: SlidingDesign, shown: Shown) -> list[Section]:
    """The controller; of each axis where it was in the phase plane and what its rules learnt."""
    found = [_controller(record, shown)]
    drives = zip(shown.machine.drives, shown.parameters, strict=True)
    limits = [min(map(abs, drive.largest_commands(own))) for drive, own in drives]
    for limit, (axis, signals) in zip(limits, (shown.signals or {}).items(), strict=False):
        name = axis.upper() if len(shown.machine.axes) > 1 else "the axis"
        found.append(_learnt(record, shown, name, learning(record, signals, limit)))
    return found


def learning(record: SlidingDesign, signals: dict[str, Floats], limit: float) -> Learning:
    """What the rules learn of what an axis with this limit measured."""
    law, gains = sliding(record.sample_time_s, limit), record.gains()
    memory, moves, before = law.initial_memory(0.0), [], record.adaptation.moves
    pairs = zip(signals["error"].tolist(), signals["error_rate"].tolist(), strict=True)
    for error, rate in pairs:
        moves.append(memory.moves)
        _, memory = law.step(SCALARS, gains, memory, {"error": error, "error_rate": rate})
    whole: Floats = np.array(moves) + (0.0 if before is None else np.array(before))
    return Learning(signals["error"], signals["error_rate"], whole)


def _controller(record: SlidingDesign, shown: Shown) -> Section:
    units, layer, own = shown.units, record.sliding, record.adaptation
    error, rate, command = units["error"], units["error_rate"], units["command"]
    of_error, of_rate = record.judge()
    rows = [
        ("error of LP", record.largest_error, error),
        ("rate of LP", record.largest_error_rate, rate),
        ("slope of the surface, λ", layer.slope, "1/s"),
        ("switching part, k", layer.gain, command),
        ("boundary layer, φ", layer.boundary_layer, rate),
        ("adaptation, γ", own.rate, f"{command}/{error}"),
        ("judgement of the error, P₂", of_error, "1/s"),
        ("judgement of its rate, P₂", of_rate, "1"),
        ("largest move of a rule", own.largest_move, command),
    ]
    for name, value in dict(record.pid or {}).items():
        per = {"k_p": error, "k_i": f"({error} s)", "k_d": f"({rate})"}[name]
        rows.append((f"beside the rules, {name}", value, f"{command}/{per}"))
    cells = [[name, f"{value:.5g}", unit] for name, value, unit in rows]
    table = np.array(record.table())
    drawing = Drawing(
        rules(table, "rules to begin with", f"command [{command}]"),
        "Heat map of the rule table",
        "Rule table: the command for each pair of terms, from large negative (LN) to large "
        "positive (LP).",
    )
    drawn = _surface(record, shown, "surface to begin with", "to begin with")
    listing = Listing("Scales, gains and limits.", ["parameter", "value", "unit"], cells)
    return Section("The controller", ABOUT, listing, [drawing, drawn])


def _learnt(record: SlidingDesign, shown: Shown, name: str, motion: Learning) -> Section:
    command = shown.units["command"]
    moved = record.with_moves(tuple(map(tuple, motion.moves[-1].tolist())))
    after, every = np.array(moved.table()), record.sample_time_s
    drawings = [
        Drawing(
            phase_plane(record, shown.units, name, motion.error, motion.rate),
            f"Error and its rate of {name} against the sliding surface",
            f"{name} in the phase plane: s = 0 is the line, the boundary layer grey. What lies "
            "beyond the layer is pushed with all of k.",
        ),
        Drawing(
            over_time(motion.moves, every, f"[{command}]", f"rules of {name} over time"),
            f"Moves of the rules of {name} over time",
            "What each rule has moved by: a block for each term of the error, in it a row for each "
            "term of its rate, LN on top.",
        ),
        Drawing(
            rules(after, f"rules of {name} at the end", f"moved by [{command}]", motion.moves[-1]),
            f"Heat map of the learnt rule table of {name}",
            f"Rule table of {name} at the end of the motion: the numbers are the commands "
            f"[{command}] by then, the colours what they have moved by.",
        ),
        _surface(moved, shown, f"surface of {name} at the end", f"of {name} at the end"),
    ]
    return Section(f"What {name} learns", "", None, drawings)


def _surface(record: SlidingDesign, shown: Shown, title: str, when: str) -> Drawing:
    return surfaces.drawing(
        surface(record, shown.units, title),
        f"Control surface {when}: what the rules command, without the switching part"
        + " and without the linear gains" * (record.pid is not None)
        + ".",
    )
