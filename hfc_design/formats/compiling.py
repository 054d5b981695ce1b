"""Compilation of C sources to a shared library for Linux on x86-64, if there is a compiler."""

import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from hfc_design.core.records import RunError

#: Options for reproducible builds: no folder names, no build identity, no fused multiply-add.
FLAGS = (
    *("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"),
    *("-ffp-contract=off", "-s", "-Wl,--build-id=none"),
)
LONGEST_S = 120.0


def compiler() -> str | None:
    """Return the path of ``cc``; None without it, and on any platform but Linux on x86-64."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return None
    return shutil.which("cc")


def note() -> str:
    """Return a line on why FMUs contain only C sources; "" if binaries are built."""
    if compiler():
        return ""
    if sys.platform == "linux" and platform.machine() == "x86_64":
        return "found no C compiler (cc): the FMUs contain only their C sources"
    return "binaries are made only on Linux on x86-64: the FMUs contain only their C sources"


def shared_library(sources: Mapping[str, str], name: str) -> bytes | None:
    """Return a shared library of all ``.c`` files in ``sources``; None without a compiler.

    Raises:
        RunError: the compiler cannot run, takes too long, or refuses the sources.
    """
    tool = compiler()
    if tool is None:
        return None
    with TemporaryDirectory() as folder:
        for file, text in sources.items():
            Path(folder, file).write_text(text, encoding="utf-8")
        files = sorted(file for file in sources if file.endswith(".c"))
        command = [tool, *FLAGS, *files, "-lm", "-o", f"{name}.so"]
        try:
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, timeout=LONGEST_S, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise RunError(f"{tool}: cannot compile an FMU: {error}") from None
        if done.returncode:
            lines = done.stderr.splitlines() or [f"exit code {done.returncode}"]
            message = next((line for line in lines if "error" in line), lines[0])
            raise RunError(f"{tool}: cannot compile an FMU: {message}")
        return Path(folder, f"{name}.so").read_bytes()
