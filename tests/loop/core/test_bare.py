"""The package on a computer that lacks what Windows lacks; see ``helpers/bare.py``."""

import os
import subprocess
import sys

import pytest
from places import ROOT, TESTS

from hfc_design.core import checkpoint
from hfc_design.core.numbers import cores

WORK = """
import sys
from pathlib import Path
import hfc_design.api
from hfc_design.core import lock
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.numbers import cores
from hfc_design.simulation import memory
folder = Path(sys.argv[1])
with lock.exclusive(folder):
    write_whole(folder / "result", b"first")
    write_whole(folder / "result", b"second")
    assert lock.in_use(folder)
assert cores() >= 1 and memory.free() > 1e8
missing = []
for name, code in {
    "fcntl": "import fcntl", "resource": "import resource",
    "affinity": "import os; os.sched_getaffinity(0)", "proc": "open('/proc/self/maps')",
    "open": "import os; x = open('half', 'w'); os.replace('half', 'whole')",
}.items():
    try:
        exec(code, {"__name__": "hfc_design.other"})
    except (ImportError, AttributeError, OSError):
        missing.append(name)
print(lock.sys.platform, *missing)
"""


def test_the_package_runs_without_what_windows_lacks(tmp_path):
    own = {"HFC_BARE": "1", "PYTHONPATH": os.pathsep.join([str(TESTS / "helpers"), str(ROOT)])}
    command = [sys.executable, "-c", WORK, str(tmp_path / "new")]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | own, cwd=tmp_path
    )
    assert done.stdout == "win32 fcntl resource affinity proc open\n", done.stderr
    assert [x.name for x in (tmp_path / "new").iterdir()] == ["result"]
    assert (tmp_path / "new" / "result").read_bytes() == b"second"


def test_a_file_that_others_read_is_replaced_when_they_have_done(tmp_path, monkeypatch):
    """On Windows a file that is open cannot be replaced."""
    tries, replace = [], type(tmp_path).replace

    def busy(path, target):
        tries.append(path)
        if len(tries) < 3:
            raise PermissionError(13, "Permission denied")
        return replace(path, target)

    monkeypatch.setattr(type(tmp_path), "replace", busy)
    checkpoint.write_whole(tmp_path / "result", b"new")
    assert (tmp_path / "result").read_bytes() == b"new"
    assert len(tries) == 3


@pytest.mark.parametrize(("count", "expected"), [(3, 3), (None, 1)])
def test_cores_where_a_process_cannot_be_bound_to_some(monkeypatch, count, expected):
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: count)
    assert cores() == expected
