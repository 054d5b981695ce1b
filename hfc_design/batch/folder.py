"""A batch on disk: which cells it has, what became of each, and who is at it.

The cells are ordinary run folders, and nothing else is written into them. What belongs to the
batch lies in ``batch.json`` and in ``.batch/``.
"""

import fcntl
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Literal, NamedTuple

from hfc_design.batch.plan import Plan, Told
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.numbers import Json
from hfc_design.core.records import Record, RunError, UserError, checked
from hfc_design.core.texts import LARGEST_TABLE, content, decoded, json_of, of
from hfc_design.runs.run import CHECKPOINT, CONFIG, DESIGN

PLAN, NOTES = "batch.json", ".batch"
State = Literal["finished", "failed", "running", "broken off", "waiting"]


class Noted(Record):
    """What ``batch.json`` holds."""

    cells: dict[str, Json] = {}  # name of a folder -> settings
    files: dict[str, Told] = {}  # by the batch's name


class Entry(NamedTuple):
    """A cell as the folder knows it."""

    name: str
    settings: Json
    state: State
    reason: str  # of a failure
    seconds: float | None  # that a finished cell took


def note_plan(out: Path, plan: Plan) -> None:
    """Add the cells to the folder's plan; others that are in it stay.

    Raises:
        RunError: the folder cannot be written.
    """
    with locked(out, "plan"):
        noted = _noted(out) if (out / PLAN).exists() else Noted()
        cells = noted.cells | {cell.name: cell.settings for cell in plan.cells}
        whole = Noted(cells=cells, files=noted.files | {plan.name: plan.told})
        write_whole(out / PLAN, (whole.model_dump_json(indent=1) + "\n").encode())


def entries(out: Path) -> list[Entry]:
    """What became of every cell of a batch; UserError: the folder holds no batch."""
    if not (out / PLAN).exists():
        raise UserError(f"{out}: holds no batch (no {PLAN})")
    found = []
    for name, settings in _noted(out).cells.items():
        reason, seconds = _text(out, name, "failed"), _text(out, name, "seconds")
        time = float(seconds) if seconds else None
        now = state(out, name)
        if now != "finished" and (out / NOTES / f"{name}.lock").exists():
            with claimed(out, name) as free:  # else somebody is at it, or has sent it to a worker
                now, reason = (now, reason) if free else ("running", "")
        found.append(Entry(name, settings, now, reason, time))
    return found


def told(out: Path) -> list[Told]:
    """What the files of the batches in a folder say beside their cells."""
    return list(_noted(out).files.values())


def state(out: Path, name: str) -> State:
    """What became of a cell."""
    if (out / name / DESIGN).exists():
        return "finished"
    if (out / NOTES / f"{name}.failed").exists():
        return "failed"
    begun = (out / name / CONFIG).exists() or (out / name / CHECKPOINT).exists()
    return "broken off" if begun else "waiting"


def note(out: Path, name: str, kind: Literal["failed", "seconds"], text: str) -> None:
    """Note why a cell failed, or how many seconds it took."""
    write_whole(out / NOTES / f"{name}.{kind}", (text + "\n").encode())


def forget_failure(out: Path, name: str) -> None:
    """A cell is tried again."""
    (out / NOTES / f"{name}.failed").unlink(missing_ok=True)


def claimed(out: Path, name: str) -> AbstractContextManager[bool]:
    """Whether this process alone may run the cell; another batch may be at it.

    The system gives the claim back when the process ends, however it ends.
    """
    return locked(out, name, wait=False)


@contextmanager
def locked(out: Path, name: str, wait: bool = True) -> Iterator[bool]:
    """One process at a time holds the lock; others ``wait``, or get False.

    Raises:
        RunError: the folder cannot be written.
    """
    try:
        (out / NOTES).mkdir(parents=True, exist_ok=True)
        file = (out / NOTES / f"{name}.lock").open("a")
    except OSError as error:
        raise RunError(f"{out}: cannot be written: {error.strerror or error}") from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            yield False
        else:
            yield True


def _noted(out: Path) -> Noted:
    with of(out / PLAN):
        plan = json_of(decoded(content(out / PLAN, LARGEST_TABLE)))
    return checked(Noted, plan, out / PLAN, out)


def _text(out: Path, name: str, kind: str) -> str:
    path = out / NOTES / f"{name}.{kind}"
    return path.read_text(encoding="utf-8").strip() if path.exists() else ""
