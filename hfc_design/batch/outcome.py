"""What a run's folder holds of how it ended: scores, the structure of its design, its history.

Raw: a design is not read as one, since that of a run made with another version counts as well.
"""

import json
from collections.abc import Iterable
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design.batch.plan import SCENARIO
from hfc_design.controllers.kinds import KINDS
from hfc_design.core.numbers import Floats, Json
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError
from hfc_design.core.texts import LARGEST_TABLE, content, decoded, json_of
from hfc_design.runs.run import DESIGN, HISTORY, USABLE

JUDGED_BY = "judged_by"
#: Answers to whether a design can be used, the best first.
VERDICTS = ("yes", "on this model only", "no")
#: Margins of a loop, of each of which ``usable.json`` has the worst.
MARGINS = ("sensitivity", "gain_margin", "phase_margin_deg", "delay_margin_samples")


class Ended(NamedTuple):
    """What a run's design says."""

    #: fitness, merit and metrics; the lowest of their repeats where fitness or merit are chaotic
    score: dict[str, float | None]
    judged_by: str  # title of the merit; "" where an earlier version made the run
    ranges: dict[str, Json]  # of a fitness or merit that is chaotic
    structure: str  # of its controller; "" where there is but one, or nobody here knows it


def ended(path: Path) -> Ended:
    """How the run in a folder ended.

    Raises:
        ValueError: the file is no design with a score.
    """
    design = json_of(decoded(content(path / DESIGN)))
    score = design.get("score") if isinstance(design, dict) else None
    if not isinstance(score, dict):
        raise ValueError("has no score")
    judged_by, ranges = score.pop(JUDGED_BY, ""), _ranges(score)
    score.pop("usable", None)  # ``use`` has more of it
    found = {key: _number(value) for key, value in score.items() if key != SCENARIO}
    if found.get("fitness") is None and score.get("fitness", "") is not None:
        raise ValueError("has no fitness that is a number")  # null: the design diverged
    lowest = {key: one["lowest"] for key, one in ranges.items()}
    all_of_it = {"fitness": None} | found | lowest
    return Ended(all_of_it, text(judged_by), ranges, _structure(design.get("controller")))


class Use(NamedTuple):
    """What a run says of whether its design can be used; empty where nobody has asked."""

    verdict: str = ""  # one of ``VERDICTS``
    share: float | None = None  # of unseen machines that pass
    margins: dict[str, float] = {}  # the worst that is told of each of ``MARGINS``
    answer: str = ""

    def told(self, margins: Iterable[str]) -> list[str]:
        """Verdict, share [%] and these margins as tables show them."""
        numbers = [self.share and 100 * self.share, *(self.margins.get(key) for key in margins)]
        return [self.verdict or "–", *("–" if x is None else f"{x:.4g}" for x in numbers)]


def use(path: Path) -> Use:
    """What the folder of a run says of whether its design can be used.

    Raises:
        ValueError: the file is damaged.
    """
    if not (path / USABLE).exists():
        return Use()
    found = json_of(decoded(content(path / USABLE)))
    if not isinstance(found, dict) or not isinstance(found.get("usable"), bool):
        raise ValueError("has no answer")
    verdict = found.get("verdict", "yes" if found["usable"] else "no")
    if verdict not in VERDICTS:
        raise ValueError(f"verdict must be {', '.join(VERDICTS)} (got {verdict!r})")
    margins = {}
    for key in MARGINS:
        with suppress(KeyError, TypeError):  # an earlier version has none
            margins[key] = float(found["margins"]["worst"][key]["value"])  # null: without an end
    return Use(verdict, _number(found.get("share")), margins, text(found.get("answer", "")))


def _structure(controller: object) -> str:
    if not isinstance(controller, dict):
        return ""
    name = str(controller.get("kind"))
    with suppress(UserError, ValueError), own_code(", its structure", ("controller", name)):
        kind = KINDS.get(name)
        return kind.structure(kind.record.model_validate(controller))
    return ""


def _ranges(score: Json) -> dict[str, Json]:
    """Takes what it says of chaos out of a score: key -> the ends of its range."""
    score.pop("chaotic", None)
    told = score.pop("repeats", None)
    each = told.items() if isinstance(told, dict) else ()
    return {
        key: {end: _number(one.get(end)) for end in ("lowest", "highest")}
        for key, one in each
        if key in ("fitness", "merit") and isinstance(one, dict)
    }


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, (int, float)) and isfinite(value) else None


def history(path: Path) -> Floats:
    """Best merit so far, (generations,), nan while everything failed.

    Raises:
        ValueError: a row is damaged or missing.
    """
    lines = decoded(content(path / HISTORY, LARGEST_TABLE)).splitlines()
    names, *rows = (line.split(",") for line in lines or [""])
    if not rows or "best" not in names:
        raise ValueError("has no column best or no generation")
    numbers = np.empty(len(rows))
    for k, row in enumerate(rows):
        if len(row) != len(names) or row[0] != str(k):
            raise ValueError(f"row {k + 2} is damaged")
        numbers[k] = float(row[names.index("best")])
    if np.isinf(numbers).any():
        raise ValueError("a score is no number")
    return numbers


def text(value: object) -> str:
    """A setting as a reader sees it."""
    told = value if isinstance(value, str) else json.dumps(value, default=str)
    return told.encode(errors="replace").decode()
