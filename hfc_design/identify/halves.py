"""Each half of a log fitted for itself: what differs is what the model lacks, or what changed.

Intervals by the residual say what chance does to a model that is right. One that is not finds other
parameters in another motion.
"""

from dataclasses import replace

import numpy as np

from hfc_design.core.numbers import Mask
from hfc_design.identify.certainty import TOLD, Certainty, certainty
from hfc_design.identify.fit import FEW, TIGHT, VAGUE, fitted, refined, side_by_side
from hfc_design.identify.kept import GIVEN
from hfc_design.identify.replay import Replay
from hfc_design.identify.search import Found

#: What is told of an interval that became wider by this share, and is this wide a share.
WIDER, SEEN = 0.5, 1e-4


def halved(found: Found, known: Certainty, states: tuple[str, ...]) -> tuple[Certainty, str]:
    """What is known, its intervals wide enough for what either half of the log tells; a note.

    A half that does not tell a parameter says nothing of it.
    """
    replay = found.problem.residual
    moves = np.array([state in ("yes", GIVEN) for state in states])
    if not isinstance(replay, Replay) or not moves.any():
        return known, ""
    counted = np.flatnonzero(replay.rows.usable)
    middle = np.arange(len(replay.rows.usable)) < counted[len(counted) // 2]
    held = np.append(moves, found.problem.held[-2:]).astype(float)

    def half(part: Mask) -> Certainty:
        rows = replay.rows._replace(usable=replay.rows.usable * part)
        own = found.problem._replace(residual=replace(replay, rows=rows), held=held)
        numbers, _ = refined(own, found.fit.numbers, TIGHT, FEW, 1.0 / VAGUE)
        return certainty(fitted(own, numbers, 0), moves)

    low, high, late = known.low.copy(), known.high.copy(), known.late
    for own in side_by_side(half, (middle, ~middle)):
        tells = moves & (own.error < TOLD) & np.isfinite(own.value)
        low[tells] = np.minimum(low, own.value)[tells]
        high[tells] = np.maximum(high, own.value)[tells]
        mid = 0.5 * (own.late[0] + own.late[1])
        late = min(late[0], mid), max(late[1], mid)
    least = np.maximum(known.high - known.low, SEEN * np.abs(known.value))
    grown = (high - low) > (1.0 + WIDER) * least
    names = ", ".join(np.array(found.fit.free.names)[grown & moves])
    told = f"the halves of the log differ in {names} by more than chance: their intervals hold both"
    return known._replace(low=low, high=high, late=late), told if names else ""
