"""A shared library of C sources for Linux on x86-64, where a C compiler is at hand."""

import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from hfc_design.core.records import RunError

#: Equal bits of equal sources: no name of a folder, no identity of a build, no fused operations.
FLAGS = (
    *("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"),
    *("-ffp-contract=off", "-s", "-Wl,--build-id=none"),
)
LONGEST_S = 120.0


def compiler() -> str | None:
    """The path of ``cc``; None where there is none, or what it makes runs elsewhere."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return None
    return shutil.which("cc")


def note() -> str:
    """What ``hfc export`` says where the sources stay alone; "": they do not."""
    if compiler():
        return ""
    if sys.platform == "linux" and platform.machine() == "x86_64":
        return "found no C compiler (cc): the FMUs contain only their C sources"
    return "binaries are made only on Linux on x86-64: the FMUs contain only their C sources"


def shared_library(sources: Mapping[str, str], name: str) -> bytes | None:
    """The library of all ``.c`` among the sources; None without a compiler.

    Raises:
        RunError: the compiler refuses them.
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
