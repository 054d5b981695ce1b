"""Results of the runs below a folder, finished or not: settings, scores, histories.

Only what a summary needs is read. A damaged file is reported with its run; the other runs are read
all the same. Designs are read as plain JSON, so that runs of another version count as well.
"""

import json
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from hfc_design.batch import folder
from hfc_design.batch.plan import SCENARIO
from hfc_design.controllers.kinds import KINDS
from hfc_design.core.numbers import Floats, Json
from hfc_design.core.overrides import flat
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError, in_a_line
from hfc_design.core.texts import LARGEST_TABLE, content, decoded, json_of, toml_of
from hfc_design.files.labels import PLAN, SEED, run_labels
from hfc_design.report import REPORT
from hfc_design.runs.run import CHECKPOINT, CONFIG, DESIGN, GIVEN, HISTORY, USABLE
from hfc_design.simulation.acceptance import NO, ON_THIS_MODEL, YES

JUDGED_BY = "judged_by"
#: Verdicts on the usability of a design, the best first.
VERDICTS = (YES, ON_THIS_MODEL, NO)
#: Margins of a loop; ``usable.json`` has the worst value of each.
MARGINS = ("sensitivity", "gain_margin", "phase_margin_deg", "delay_margin_samples")
#: Keys of ``config.toml`` that are not settings.
SAID = ("name", "description")
State = folder.State | Literal["unreadable"]


class Run(NamedTuple):
    """A run as described by its folder."""

    path: str  # relative to the folder whose runs are read
    settings: Json  # dotted key -> value; also scenario and run.seed
    state: State
    reason: str  # why it is not finished, or what could not be read; "" if neither
    score: dict[str, float | None] = {}  # fitness, merit and metrics if it is finished
    best: Floats = np.empty(0)  # (generations,) best merit so far, nan while all failed
    page: bool = False  # has a report of its own
    searched: bool = True  # False: its design was given, so nothing is random
    judged_by: str = ""  # title of the merit; "": not finished, or made by an earlier version
    ranges: dict[str, Json] = {}  # ends of a chaotic fitness or merit; ``score`` has the lowest
    structure: str = ""  # of its design; "" if its kind of controller has only one
    verdict: str = ""  # whether its design can be used, one of ``VERDICTS``; "": not evaluated
    share: float | None = None  # of unseen machines that pass
    margins: dict[str, float] = {}  # worst value of each of ``MARGINS``, if it is known
    answer: str = ""  # the whole line on whether its design can be used
    called: str = ""  # label of its cell in the batch; "" outside a batch

    @property
    def title(self) -> str:
        """Title of the run: its path, with the label of the cell as the last part in a batch."""
        return text((Path(self.path).parent / self.called).as_posix()) if self.called else self.path

    def place(self) -> tuple[float, ...]:
        """Sort key among runs, the best first: usability of the design, share, merit."""
        numbers = (-(x or 0.0) for x in (self.share, self.score.get("merit")))
        return [*VERDICTS, ""].index(self.verdict), *numbers

    def setting(self, key: str) -> str:
        """Text of a setting; a dash if it is missing."""
        return text(self.settings[key]) if key in self.settings else "–"


def is_run(path: Path) -> bool:
    """Return True if a folder is that of a single run."""
    files = any((path / name).exists() for name in (CONFIG, CHECKPOINT, DESIGN))
    return files and not (path / PLAN).exists()


def batches_below(path: Path) -> list[Path]:
    """Folders of batches: the folder itself, or those below it."""
    return [place for place in _folders(path) if (place / PLAN).exists()]


def runs_below(path: Path) -> list[Run]:
    """Return all runs below a folder, in batches and alone; the best first if any has an answer.

    Raises:
        UserError: it is not a folder, there is no run, or a batch's plan is damaged.
    """
    if not path.is_dir():
        raise UserError(f"{path}: must be a folder")
    planned: list[Run] = []
    alone: list[Run] = []
    for place in _folders(path):
        if not (place / PLAN).exists():
            alone.append(_alone(place, path))
            continue
        cells = folder.entries(place)
        called = run_labels({cell.name: cell.settings for cell in cells})
        for cell in cells:
            settings = {SCENARIO: "c-axis-ramp", SEED: 0} | cell.settings
            run = _read(place / cell.name, path, settings, cell.state, cell.reason)
            planned.append(run._replace(called=called[cell.name]))
    runs = planned + _told_apart(alone, {key for run in planned for key in run.settings})
    if not runs:
        raise UserError(f"{path}: holds no runs ({PLAN}, or folders with a {CONFIG})")
    return sorted(runs, key=Run.place) if any(run.verdict for run in runs) else runs


def best_usable(path: Path) -> Run:
    """Return the run below a folder that has the best usable design.

    Raises:
        UserError: there is no such run, or no run states whether its design is usable.
    """
    first = runs_below(path)[0]
    if first.verdict == YES:
        return first
    near = f"the closest is {first.title}, with the answer {first.answer}"
    none = "usability is judged only in scenarios with [robust]"
    reason = near if first.verdict else none
    raise UserError(f"{path}: no run has a usable design; {reason}")


def _folders(path: Path) -> Iterator[Path]:
    """Yield the folders of batches and of runs, sorted by name; folders in these are skipped."""
    if (path / PLAN).exists() or is_run(path):
        yield path
        return
    try:
        inside = sorted(inner for inner in path.iterdir() if inner.is_dir())
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror}") from None
    for inner in inside:
        loop = inner.is_symlink() and not is_run(inner)  # a link may lead back
        if not loop and not inner.name.startswith("."):
            yield from _folders(inner)


def _alone(path: Path, top: Path) -> Run:
    """Return a run outside every batch, with all settings of its configuration."""
    try:
        config = toml_of(decoded(content(path / CONFIG)))
    except ValueError as error:
        return Run(_below(path, top), {}, "unreadable", in_a_line(f"{CONFIG}: {error}"))
    said = {key: value for key, value in flat(config).items() if key not in SAID}
    settings = {SCENARIO: config.get("name", "")} | said
    return _read(path, top, settings, "finished" if (path / DESIGN).exists() else "broken off")


def _told_apart(runs: list[Run], known: set[str]) -> list[Run]:
    """Return the runs with only settings that differ within a scenario, or are in ``known``.

    Different scenarios differ in dozens of keys, which say no more than the scenarios' names.
    """
    values: dict[tuple[str, str], set[str]] = defaultdict(set)
    for run in runs:
        for key, value in run.settings.items():
            values[run.setting(SCENARIO), key].add(text(value))
    differing = {key for (_, key), different in values.items() if len(different) > 1}
    keys = differing | known | {SCENARIO, SEED}
    return [
        run._replace(settings={key: x for key, x in run.settings.items() if key in keys})
        for run in runs
    ]


def _read(path: Path, top: Path, settings: Json, state: State, reason: str = "") -> Run:
    """Return a run with what its files say; a file that cannot be read is its ``reason``."""
    searched, page = not (path / GIVEN).exists(), (path / REPORT).exists()
    run = Run(_below(path, top), settings, state, reason, searched=searched, page=page)
    files = {DESIGN: _ended, USABLE: _use} if state == "finished" else {}
    if (files and searched) or (path / HISTORY).exists():
        files[HISTORY] = _history
    for name, fields in files.items():
        try:
            run = run._replace(**fields(path / name))
        except ValueError as error:
            fault = in_a_line(f"{name}: {error}")  # the same in every folder
            run = run._replace(reason=f"{run.reason}; {fault}".removeprefix("; "))
            if name == DESIGN:
                run = run._replace(state="unreadable")
    if run.state in ("running", "broken off") and not run.reason:
        done = f"after {len(run.best)} generations" if len(run.best) else ""
        run = run._replace(reason=done or "before the first checkpoint")
    return run


def _ended(file: Path) -> Json:
    """Return fields of ``Run`` from a design; ValueError: it is not a design with a score."""
    design = json_of(decoded(content(file)))
    score = design.get("score") if isinstance(design, dict) else None
    if not isinstance(score, dict):
        raise ValueError("has no score")
    judged_by, ranges = score.get(JUDGED_BY, ""), _ranges(score.get("repeats"))
    others = (SCENARIO, JUDGED_BY, "usable", "chaotic", "repeats")  # usability: ``_use``
    numbers = {key: _number(value) for key, value in score.items() if key not in others}
    if numbers.get("fitness") is None and score.get("fitness", "") is not None:
        raise ValueError("must have a number as fitness")  # null: the design diverged
    lowest = {key: ends["lowest"] for key, ends in ranges.items()}
    structure = _structure(design.get("controller"))
    fields = {"judged_by": text(judged_by), "ranges": ranges, "structure": structure}
    return {"score": {"fitness": None} | numbers | lowest} | fields


def _ranges(repeats: object) -> dict[str, Json]:
    """Return the lowest and the highest value of the fitness and of the merit, if chaotic."""
    return {
        key: {end: _number(ends.get(end)) for end in ("lowest", "highest")}
        for key, ends in (repeats.items() if isinstance(repeats, dict) else ())
        if key in ("fitness", "merit") and isinstance(ends, dict)
    }


def _structure(controller: object) -> str:
    if not isinstance(controller, dict):
        return ""
    name = str(controller.get("kind"))
    with suppress(UserError, ValueError), own_code(", its structure", ("controller", name)):
        kind = KINDS.get(name)
        return kind.structure(kind.record.model_validate(controller))
    return ""


def _use(file: Path) -> Json:
    """Return fields of ``Run`` on the usability, if the file exists; ValueError: it is damaged."""
    if not file.exists():
        return {}
    record = json_of(decoded(content(file)))
    if not isinstance(record, dict) or not isinstance(record.get("usable"), bool):
        raise ValueError("has no answer")
    verdict = record.get("verdict", YES if record["usable"] else NO)
    if verdict not in VERDICTS:
        raise ValueError(f"verdict must be {', '.join(VERDICTS)} (got {verdict!r})")
    margins = {}
    for key in MARGINS:
        with suppress(KeyError, TypeError):  # an earlier version has none
            margins[key] = float(record["margins"]["worst"][key]["value"])  # null: unlimited
    answer, share = text(record.get("answer", "")), _number(record.get("share"))
    return {"verdict": verdict, "share": share, "margins": margins, "answer": answer}


def _history(file: Path) -> Json:
    """Return the field ``best`` of ``Run``; ValueError: a row is damaged or missing."""
    lines = decoded(content(file, LARGEST_TABLE)).splitlines()
    names, *rows = (line.split(",") for line in lines or [""])
    if not rows or "best" not in names:
        raise ValueError("must have a column best and at least one generation")
    for k, row in enumerate(rows):
        if len(row) != len(names) or row[0] != str(k):
            raise ValueError(f"row {k + 2} is damaged")
    best = np.array([float(row[names.index("best")]) for row in rows])
    if np.isinf(best).any():
        raise ValueError("a score is not a number")
    return {"best": best}


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, (int, float)) and isfinite(value) else None


def _below(path: Path, top: Path) -> str:
    return text(path.relative_to(top).as_posix())


def listed(counts: Mapping[Any, int]) -> str:
    """Return a text with the count of each state."""
    return ", ".join(f"{count} {state}" for state, count in counts.items())


def text(value: object) -> str:
    """Return the text of a setting: a string as it is, other values as JSON."""
    said = value if isinstance(value, str) else json.dumps(value, default=str)
    return said.encode(errors="replace").decode()
