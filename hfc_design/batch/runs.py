"""The runs below a folder, as far as they have come: settings, scores, histories.

Only what a summary needs is read; whatever is damaged is told beside the run and stops nothing.
"""

import json
from collections import defaultdict
from collections.abc import Iterator, Mapping
from math import isfinite
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from hfc_design.batch import folder
from hfc_design.batch.plan import SCENARIO
from hfc_design.core.dotted import flat
from hfc_design.core.numbers import Floats, Json
from hfc_design.core.records import UserError, in_a_line
from hfc_design.core.texts import LARGEST_TABLE, content, decoded, json_of, toml_of
from hfc_design.report import REPORT
from hfc_design.runs.run import CHECKPOINT, CONFIG, DESIGN, GIVEN, HISTORY

State = folder.State | Literal["unreadable"]
SEED, JUDGED_BY = "run.seed", "judged_by"
#: What ``config.toml`` says beside the settings.
SAID = ("name", "description")


class Run(NamedTuple):
    """A run as its folder tells it."""

    path: str  # below the folder that was asked for
    settings: Json  # dotted key -> value; also scenario and run.seed
    state: State
    reason: str  # why it is not finished or not all of it could be read; "" if it is
    score: dict[str, float | None] = {}  # fitness, merit and metrics if it is finished
    best: Floats = np.empty(0)  # (generations,) best merit so far, nan while all failed
    page: bool = False  # has a report of its own
    searched: bool = True  # else its design was given, and nothing is random
    judged_by: str = ""  # title of the merit; "" where an earlier version made the run
    ranges: dict[str, Json] = {}  # of a fitness or merit that is chaotic; ``score`` has its lowest

    def setting(self, key: str) -> str:
        """A setting as a reader sees it, a dash where there is none."""
        return text(self.settings[key]) if key in self.settings else "–"


def is_run(path: Path) -> bool:
    """Whether a folder is that of a run, and not of many."""
    own = any((path / name).exists() for name in (CONFIG, CHECKPOINT, DESIGN))
    return own and not (path / folder.PLAN).exists()


def runs_below(path: Path) -> list[Run]:
    """Every run of the batches and every other run folder below a folder.

    Raises:
        UserError: there is none, or a batch's plan is damaged.
    """
    if not path.is_dir():
        raise UserError(f"{path}: is no folder")
    planned: list[Run] = []
    alone: list[Run] = []
    for place in _folders(path):
        if (place / folder.PLAN).exists():
            for cell in folder.entries(place):
                settings = {SCENARIO: "c-axis-ramp", SEED: 0} | cell.settings
                planned.append(_read(place / cell.name, path, settings, cell.state, cell.reason))
        else:
            alone.append(_alone(place, path))
    found = planned + _told_apart(alone, {key for run in planned for key in run.settings})
    if not found:
        raise UserError(f"{path}: holds no runs ({folder.PLAN}, or folders with a {CONFIG})")
    return found


def batches_below(path: Path) -> list[Path]:
    """The folders of batches below a folder, or itself."""
    return [place for place in _folders(path) if (place / folder.PLAN).exists()]


def _folders(path: Path) -> Iterator[Path]:
    """Folders of batches and of runs, in the order of their names; nothing inside one of them."""
    if (path / folder.PLAN).exists() or is_run(path):
        yield path
        return
    try:
        inside = sorted(inner for inner in path.iterdir() if inner.is_dir())
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror}") from None
    for inner in inside:
        loop = inner.is_symlink() and not is_run(inner)  # perhaps, so it is left alone
        if not loop and not inner.name.startswith("."):
            yield from _folders(inner)


def _alone(path: Path, top: Path) -> Run:
    """A run outside of every batch; its settings are all that its configuration says."""
    try:
        config = toml_of(decoded(content(path / CONFIG)))
    except ValueError as error:
        return Run(_below(path, top), {}, "unreadable", _told(CONFIG, error))
    said = {key: value for key, value in flat(config).items() if key not in SAID}
    settings = {SCENARIO: config.get("name", "")} | said
    return _read(path, top, settings, "finished" if (path / DESIGN).exists() else "broken off")


def _told_apart(runs: list[Run], known: set[str]) -> list[Run]:
    """The runs with those settings only that differ between runs of the same scenario.

    Two scenarios differ in dozens of keys that say no more than their names do.
    """
    values: dict[tuple[str, str], set[str]] = defaultdict(set)
    for run in runs:
        for key, value in run.settings.items():
            values[run.setting(SCENARIO), key].add(text(value))
    differing = {key for (_, key), found in values.items() if len(found) > 1}
    kept = differing | known | {SCENARIO, SEED}
    return [
        run._replace(settings={key: v for key, v in run.settings.items() if key in kept})
        for run in runs
    ]


def _read(path: Path, top: Path, settings: Json, state: State, reason: str = "") -> Run:
    score: dict[str, float | None] = {}
    judged_by, best, searched = "", np.empty(0), not (path / GIVEN).exists()
    ranges: dict[str, Json] = {}
    if state == "finished":
        try:
            score, judged_by, ranges = _score(path)
        except ValueError as error:
            state, reason = "unreadable", _told(DESIGN, error)
    if (path / HISTORY).exists() or (state == "finished" and searched):
        try:
            best = _best(path)
        except ValueError as error:
            reason = f"{reason}; {_told(HISTORY, error)}".removeprefix("; ")
    if state in ("running", "broken off") and not reason:
        reason = f"after {len(best)} generations" if len(best) else "before the first checkpoint"
    page = (path / REPORT).exists()
    told = (settings, state, reason, score, best, page, searched, judged_by, ranges)
    return Run(_below(path, top), *told)


def _score(path: Path) -> tuple[dict[str, float | None], str, dict[str, Json]]:
    """Fitness, merit and metrics in a run's design, what the merit is, and ranges of chaos.

    Where fitness or merit are chaotic they are the lowest of their repeats.

    Raises:
        ValueError: the file is no design with a score.
    """
    design = json_of(decoded(content(path / DESIGN)))
    score = design.get("score") if isinstance(design, dict) else None
    if not isinstance(score, dict):
        raise ValueError("has no score")
    judged_by, ranges = score.pop(JUDGED_BY, ""), _ranges(score)
    found = {key: _number(value) for key, value in score.items() if key != SCENARIO}
    if found.get("fitness") is None and score.get("fitness", "") is not None:
        raise ValueError("has no fitness that is a number")  # null: the design diverged
    lowest = {key: one["lowest"] for key, one in ranges.items()}
    return {"fitness": None} | found | lowest, text(judged_by), ranges


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


def _best(path: Path) -> Floats:
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


def _told(file: str, error: ValueError) -> str:
    """What is wrong with a file, in a line that does not depend on where it lies."""
    return in_a_line(f"{file}: {error}")


def listed(counts: Mapping[Any, int]) -> str:
    """How many there are of each state."""
    return ", ".join(f"{count} {state}" for state, count in counts.items())


def text(value: object) -> str:
    """A setting as a reader sees it."""
    told = value if isinstance(value, str) else json.dumps(value, default=str)
    return told.encode(errors="replace").decode()


def _below(path: Path, top: Path) -> str:
    return text(path.relative_to(top).as_posix())
