"""Every write, sync, rename and folder of a design run fails once, for good, or is its last.

A process that is killed is one of which no later call reaches the disk, its own clearing up
included; a file that it was writing keeps half of what it was given. The oracle is the run to
which nothing happened.
"""

import errno
import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from attack import SEED, Attack, rounds
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.core import archive
from hfc_design.core.checkpoint import tidy, write_whole
from hfc_design.core.lock import LOCK, TEMPORARY
from hfc_design.formats.writing import write
from hfc_design.report import page
from hfc_design.runs import run, stored

SCENARIO = """
reference = {kind = "csv", file = "way.csv"}
simulation = {duration_s = 0.1}
controller = {kind = "pd"}
search = {population = 6, generations = 3}
"""


#: Calls that may fail and nothing is lost.
HARMLESS = ("look", "mkdir", "unlink")


class Killed(BaseException):
    pass


class Faults:
    """Counts calls that change a folder; from the one ``at`` on they fail as is said ``how``."""

    def __init__(self, folder, at=0, how=None):
        self.folder, self.at, self.how, self.calls = str(folder), at, how, []

    def may(self, what, path):
        """Let a call on a path go on, or not."""
        if not str(path).startswith(self.folder):
            return
        self.calls.append(what)
        now = len(self.calls)
        if self.how == "killed" and now >= self.at > 0:
            raise Killed
        if self.how == "full" and now >= self.at and what not in ("look", "replace", "unlink"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if isinstance(self.how, int) and now == self.at:
            raise OSError(self.how, os.strerror(self.how))

    def watch(self, patch):
        """Be told of every call."""
        opened, fsync, real_open = Path.open, os.fsync, os.open
        paths = {}

        def open_file(path, mode="r", *others, **more):
            if "r" in mode:
                return opened(path, mode, *others, **more)
            self.may("open", path)
            return _File(opened(path, mode, *others, **more), path, self)

        def open_descriptor(path, flags, *others, **more):
            self.may("open" if flags & os.O_CREAT else "look", path)
            found = real_open(path, flags, *others, **more)
            paths[found] = path
            return found

        def sync(descriptor):
            place = f"/proc/self/fd/{descriptor}"
            self.may("fsync", os.readlink(place))
            fsync(descriptor)

        patch.setattr(Path, "open", open_file)
        patch.setattr(os, "open", open_descriptor)
        patch.setattr(os, "fsync", sync)
        for name in ("replace", "rename", "mkdir", "unlink"):
            patch.setattr(os, name, self._watched(name, getattr(os, name)))

    def _watched(self, name, real):
        def call(path, *others, **more):
            self.may(name, path)
            return real(path, *others, **more)

        return call


class _File:
    def __init__(self, file, path, faults):
        self._file, self._path, self._faults = file, path, faults

    def write(self, content):
        try:
            self._faults.may("write", self._path)
        except BaseException:
            self._file.write(content[: len(content) // 2])
            raise
        return self._file.write(content)

    def flush(self):
        self._faults.may("write", self._path)
        self._file.flush()

    def __getattr__(self, name):
        return getattr(self._file, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()


@pytest.fixture
def scenario(tmp_path, monkeypatch):
    """A scenario that names a file; a report is a word, as its pictures take long."""

    def written(own, result, folder):
        write(folder / "tables", {"unit-0.csv": "0", "unit-1.csv": "1"})
        write_whole(folder / "report.html", b"the page")
        return {}

    monkeypatch.setattr(page, "write_page", written)
    monkeypatch.setattr(stored, "CHECKPOINT_EVERY", 0.0)
    (tmp_path / "way.csv").write_text("time_s,reference_rad\n0,0\n0.05,0.001\n0.1,0.0015\n")
    (tmp_path / "mine.toml").write_text(SCENARIO)
    return tmp_path / "mine.toml"


def hfc(*arguments):
    found = CliRunner().invoke(main, ["design", *map(str, arguments), "--quiet"])
    if found.exit_code == 0:
        return "done"
    lines = found.stderr.splitlines()
    assert found.exit_code in (1, 2), (found.output, found.exception)
    assert isinstance(found.exception, SystemExit), found.exception
    assert len(lines) == 1, lines
    assert lines[0].startswith("hfc: "), lines
    return "refused" if found.exit_code == 2 else "told"


def contents(folder):
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_at_every_call(scenario, tmp_path, monkeypatch):
    whole, out = tmp_path / "whole", tmp_path / "runs" / "out"
    hfc(scenario, "--out", whole)
    out.parent.mkdir()
    undisturbed = contents(whole)
    quiet = Faults(out)
    with monkeypatch.context() as patch:
        quiet.watch(patch)
        assert hfc(scenario, "--out", out) == "done"
    assert contents(out) == undisturbed
    assert {"mkdir", "open", "write", "fsync", "replace"} <= set(quiet.calls)
    everything = [
        (at, how)
        for at in range(1, len(quiet.calls) + 1)
        for how in (errno.ENOSPC, errno.EIO, errno.EINTR, "full", "killed")
    ]
    tried = random.Random(SEED).sample(everything, rounds(8, len(everything)))
    attack = Attack("faults at writes")

    def outcome(at, how):
        shutil.rmtree(out)
        faults = Faults(out, at, how)
        with monkeypatch.context() as patch:
            faults.watch(patch)
            try:
                found = hfc(scenario, "--out", out)
            except Killed:
                found = "killed"
        # The folder may be there already, and a lock is free though its file cannot be removed.
        unharmed = found == "done" and faults.calls[at - 1] in HARMLESS
        assert unharmed or found == ("killed" if how == "killed" else "told"), faults.calls[at - 1]
        left = contents(out) if out.exists() else {}
        half = {name.partition("/")[0] for name in left if name.startswith(TEMPORARY[0])}
        assert len(half) <= (how == "killed"), (half, at, how)
        for name, content in left.items():
            told = name.startswith(TEMPORARY[0]) or name in (LOCK, "checkpoint.npz", "history.csv")
            assert told or content == undisturbed[name], (name, at, how)
        if "checkpoint.npz" in left:
            assert archive.is_whole(left["checkpoint.npz"])
        begun = "config.toml" in left
        assert hfc(*(["--resume"] if begun else [scenario]), "--out", out) == "done", (at, how)
        assert contents(out) == undisturbed
        return found

    for at, how in tried:
        attack.input(outcome, at, how)
    attack.end(calls=len(quiet.calls))


def test_what_stands_in_the_way_is_not_touched(scenario, tmp_path):
    """Names of half-written files cannot be foreseen, and none is followed."""
    precious, out = tmp_path / "precious", tmp_path / "out"
    precious.write_text("precious")
    out.mkdir()
    names = ("config.toml.new", "reference.csv", "history.csv", ".hfc-.new")
    for name in names:
        (out / name).symlink_to(precious)
    assert hfc(scenario, "--out", out) == "done"
    assert precious.read_text() == "precious"
    assert (out / "config.toml.new").is_symlink()
    assert not (out / "reference.csv").is_symlink()
    before = (out / "design.json").read_bytes()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("secrets.token_hex", lambda count: "known")
        (out / ".hfc-known.new").symlink_to(precious)
        with pytest.raises(run.RunError, match="File exists"):
            write_whole(out / "design.json", b"other")
    assert precious.read_text() == "precious"
    assert (out / ".hfc-known.new").is_symlink()
    assert (out / "design.json").read_bytes() == before


def test_what_a_write_leaves_is_as_any_file(tmp_path):
    """Readable by whom the user lets read, and beside it nothing."""
    (tmp_path / "plain").write_bytes(b"")
    write_whole(tmp_path / "own", b"content")
    assert (tmp_path / "own").stat().st_mode == (tmp_path / "plain").stat().st_mode
    assert {path.name for path in tmp_path.iterdir()} == {"plain", "own"}


def test_a_process_that_is_killed_as_it_moves_a_folder_leaves_nothing_that_stays(tmp_path):
    """Who comes next tidies up."""
    code = """
import os, sys
from pathlib import Path
from hfc_design.formats import writing
writing._move = lambda whole, path: os._exit(9)
writing.write(Path(sys.argv[1]), {"unit-0.csv": "1", "more": {"unit-1.csv": "2"}})
"""
    ended = subprocess.run([sys.executable, "-c", code, tmp_path / "tables"], check=False)
    assert ended.returncode == 9
    (half,) = tmp_path.iterdir()
    assert (half / "whole" / "more" / "unit-1.csv").read_text() == "2"
    tidy(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_place_of_a_file_is_seen_before_the_first_is_written(tmp_path):
    (tmp_path / "out" / "lin_lee_1999_table_1.h").mkdir(parents=True)
    name = "lin-lee-1999-table-1"
    options = ["export", name, "--to", "c", "--out", str(tmp_path / "out"), "--force"]
    found = CliRunner().invoke(main, options)
    assert (found.exit_code, found.stderr.count("\n")) == (1, 1)
    assert f"{tmp_path / 'out' / 'lin_lee_1999_table_1.h'}: cannot be written" in found.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["lin_lee_1999_table_1.h"]


def test_folders_of_files_stay_whatever_becomes_of_the_machine(tmp_path, monkeypatch):
    """A new one and one that is written into: it, or the folder that names it, is synced last."""
    synced, fsync = [], os.fsync

    def noted(descriptor):
        synced.append(os.readlink(f"/proc/self/fd/{descriptor}"))
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", noted)
    write(tmp_path / "tables", {"unit-0.csv": "1"})
    assert synced[-1] == str(tmp_path)
    write(tmp_path / "tables", {"unit-0.csv": "2", "unit-1.csv": "3"})
    assert synced[-1] == str(tmp_path / "tables")
