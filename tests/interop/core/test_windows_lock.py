"""The lock of a run folder on Windows, as far as Wine can tell."""

import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

SOURCE = Path(__file__).with_name("windows_lock.c")


@pytest.mark.skipif(not find_spec("ziglang"), reason="ziglang is not installed")
@pytest.mark.skipif(not shutil.which("wine"), reason="wine is not installed")
def test_the_calls_of_windows_do_what_the_lock_needs(tmp_path):
    program = tmp_path / "windows_lock.exe"
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu"]
    subprocess.run([*zig, "-Wall", "-Wextra", SOURCE, "-o", program], check=True)
    (folder := tmp_path / "run").mkdir()
    own = os.environ | {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"}
    done = subprocess.run(
        ["wine", program], cwd=folder, env=own, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout.strip()) == (0, "as expected"), done.stderr
