"""What else lies in the folder of a batch: names that lead out of it, notes that are none."""

import json
import os

import pytest
from batches import batch
from run_folders import batch_folder, hfc
from wording import refused_command

from hfc_design.batch import folder

OUTSIDE = [
    "../evil",
    "/etc",
    "",
    "a\0b",
    "x" * 65,
]


def noted(out, name):
    """Add a cell to the plan."""
    plan = json.loads((out / "batch.json").read_text())
    plan["cells"][name] = {}
    (out / "batch.json").write_text(json.dumps(plan))


@pytest.mark.parametrize("name", OUTSIDE)
def test_names_of_cells_stay_in_the_folder(name, tmp_path):
    out = tmp_path / "out"
    batch_folder(out, [({}, [1.0])])
    noted(out, name)
    for command in (("batch", "--status", out), ("report", out, "--each")):
        found = refused_command(*command)
        assert found.count("\n") == 1
        assert found.where == str(out / "batch.json")
    assert os.listdir(tmp_path) == ["out"]


def test_a_link_that_leads_out_of_the_folder_is_no_cell(tmp_path):
    out, other = tmp_path / "out", tmp_path / "elsewhere"
    (name,) = batch_folder(out, [({}, [1.0])])
    other.mkdir()
    (out / "inside").symlink_to(out / name)
    noted(out, "inside")
    assert "2 finished" in batch("--status", out).output
    (out / "outside").symlink_to(other)
    noted(out, "outside")
    for command in (("batch", "--status", out), ("report", out, "--each")):
        found = refused_command(*command)
        assert "cells.outside" in found
        assert found.count("\n") == 1
    assert list(other.iterdir()) == []


def test_nothing_of_a_note_or_a_setting_moves_the_terminal(tmp_path):
    (name,) = batch_folder(tmp_path, [({}, [1.0])])
    (tmp_path / name / "design.json").unlink()
    plan = json.loads((tmp_path / "batch.json").read_text())
    plan["cells"][name]["label"] = "\x1b[31mred\x07"
    (tmp_path / "batch.json").write_text(json.dumps(plan))
    (tmp_path / ".batch").mkdir()
    (tmp_path / ".batch" / f"{name}.failed").write_text("\x1b]0;title\x07 it failed")
    shown = batch("--status", tmp_path).output
    assert "it failed" in shown
    assert "red" in shown
    assert "\x1b" not in shown
    assert "\x07" not in shown


def test_notes_behind_a_link_are_not_written(tmp_path):
    out, other = tmp_path / "out", tmp_path / "elsewhere"
    batch_folder(out, [({}, [1.0])])
    other.mkdir()
    (out / ".batch").symlink_to(other)
    found = refused_command("report", out)
    assert (found.where, found.count("\n")) == (str(out / ".batch"), 1)
    assert list(other.iterdir()) == []


@pytest.mark.parametrize(
    "garbage", [b"garbage", b"\xff\xfe", b"nan", b"-inf", b"1e999", b"-3", b"9" * 5000, b"", None]
)
def test_notes_that_are_none_stop_nothing(garbage, tmp_path):
    """``--status`` and the report go on; None: a folder and a pipe."""
    first, second, third = batch_folder(tmp_path, [({}, [1.0, 2.0, 3.0])])
    (tmp_path / second / "design.json").unlink()
    notes = tmp_path / ".batch"
    notes.mkdir()
    for k, name in enumerate((f"{first}.seconds", f"{third}.seconds", f"{second}.failed")):
        if garbage is not None:
            (notes / name).write_bytes(garbage)
        elif k:
            (notes / name).mkdir()
        else:
            os.mkfifo(notes / name)
    found = batch("--status", tmp_path)
    assert found.exit_code == 0, found.output
    assert "3 cells in" in found.output
    assert "2 finished" in found.output
    assert "time of a finished cell" not in found.output or garbage == b"9" * 5000
    assert hfc("report", tmp_path).exit_code == 0
    assert all(entry.reason.isprintable() for entry in folder.entries(tmp_path))
