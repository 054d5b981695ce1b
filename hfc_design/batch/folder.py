"""A batch on disk: its cells, the state of each, and the lock of the process that runs it.

The cells are ordinary run folders, and nothing else is written into them. The files of the batch
itself are ``batch.json`` and those in ``.batch/``.
"""

import shutil
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

from pydantic import AfterValidator, ValidationInfo

from hfc_design.batch.plan import BatchNotes, Plan
from hfc_design.core import lock
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.numbers import Json, number_or_none
from hfc_design.core.records import Name, Record, UserError, checked, in_a_line
from hfc_design.core.texts import LARGEST_TABLE, content, decoded, read_json
from hfc_design.files.labels import PLAN
from hfc_design.runs.run import CHECKPOINT, CONFIG, DESIGN

NOTES = ".batch"
State = Literal["finished", "failed", "running", "broken off", "waiting"]


def _inside(name: str, info: ValidationInfo) -> str:
    out = Path((info.context or {}).get("folder", ""))
    if (out / name).is_symlink() and (out / name).resolve().parent != out.resolve():
        raise ValueError("must not be a link that leads out of the folder")
    return name


class PlanFile(Record):
    """Content of ``batch.json``."""

    cells: dict[Annotated[Name, AfterValidator(_inside)], Json] = {}  # name of a folder -> settings
    files: dict[str, BatchNotes] = {}  # name of a batch -> its notes


class Entry(NamedTuple):
    """A cell with its state in the folder."""

    name: str
    settings: Json
    state: State
    reason: str  # of a failure
    seconds: float | None  # duration of a finished cell


def note_plan(out: Path, plan: Plan) -> None:
    """Add the cells to the folder's plan, and keep others in it; RunError: it cannot be written."""
    with waited(out, "plan"):
        before = _plan_file(out) if (out / PLAN).exists() else PlanFile()
        cells = before.cells | {cell.name: cell.settings for cell in plan.cells}
        files = before.files | {plan.name: plan.notes}
        whole = checked(PlanFile, {"cells": cells, "files": files}, out / PLAN, out)
        write_whole(out / PLAN, (whole.model_dump_json(indent=1) + "\n").encode())


def entries(out: Path) -> list[Entry]:
    """Return every cell of a batch with its state; UserError: the folder contains no batch."""
    if not (out / PLAN).exists():
        raise UserError(f"{out}: holds no batch (no {PLAN})")
    listed = []
    for name, settings in _plan_file(out).cells.items():
        reason = _text(out, name, "failed")
        seconds = number_or_none(_text(out, name, "seconds")) or 0.0
        now = state(out, name)
        if now != "finished" and lock.in_use(out / name):  # by this or another process
            now, reason = "running", ""
        listed.append(Entry(name, settings, now, reason, seconds if seconds > 0.0 else None))
    return listed


def batch_notes(out: Path) -> list[BatchNotes]:
    """Return the notes of each batch file whose cells are in the folder."""
    return list(_plan_file(out).files.values())


def state(out: Path, name: str) -> State:
    """Return the state of a cell from its files, without "running", which ``entries`` adds."""
    if (out / name / DESIGN).exists():
        return "finished"
    if (out / NOTES / f"{name}.failed").exists():
        return "failed"
    begun = (out / name / CONFIG).exists() or (out / name / CHECKPOINT).exists()
    return "broken off" if begun else "waiting"


def note(out: Path, name: str, kind: Literal["failed", "seconds"], text: str) -> None:
    """Note why a cell failed, or how many seconds it took; "": remove the note."""
    path = out / NOTES / f"{name}.{kind}"
    if path.is_dir() and not path.is_symlink():  # a folder is no note
        shutil.rmtree(path, ignore_errors=True)
    if text:
        write_whole(path, (text + "\n").encode())
    else:
        path.unlink(missing_ok=True)


def waited(out: Path, what: str) -> AbstractContextManager[None]:
    """Context that waits for the lock ``what`` of a batch, which one process at a time can have.

    Raises:
        UserError: the folder of the notes is a link; another folder would be changed through it.
    """
    if (out / NOTES).is_symlink():
        raise UserError(f"{out / NOTES}: must be a folder, not a link")
    return lock.wait_for(out, out / NOTES / f"{what}.lock")


def _plan_file(out: Path) -> PlanFile:
    return checked(PlanFile, read_json(out / PLAN, LARGEST_TABLE), out / PLAN, out)


def _text(out: Path, name: str, kind: str) -> str:
    """Text of a note; "" if it cannot be read, since a note is not essential."""
    with suppress(ValueError):
        return in_a_line(decoded(content(out / NOTES / f"{name}.{kind}"), errors="replace"))
    return ""
