"""Compilation of C sources to shared libraries, for each platform that a compiler here can make."""

import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from hfc_design.core.records import RunError

#: Options for reproducible builds: no folder names, no build identity, no fused multiply-add.
FLAGS = (
    *("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"),
    *("-ffp-contract=off", "-s", "-Wl,--build-id=none"),
)
#: The first library for Windows takes long: zig compiles the C library for it, and keeps that.
LONGEST_S = 900.0


class Platform(NamedTuple):
    """A platform, by the names of its folder in an FMU (FMI 2.0.5 and 3.0.2, ``binaries``)."""

    fmi3: str
    fmi2: str
    target: str  # of the compiler zig, with the oldest version of macOS or the GNU C library
    ending: str = ".so"


LINUX = Platform("x86_64-linux", "linux64", "x86_64-linux-gnu.2.17")
PLATFORMS = (
    LINUX,
    Platform("aarch64-linux", "aarch64-linux", "aarch64-linux-gnu.2.17"),
    Platform("x86_64-windows", "win64", "x86_64-windows-gnu", ".dll"),
    Platform("x86_64-darwin", "darwin64", "x86_64-macos.11.0", ".dylib"),
    Platform("aarch64-darwin", "aarch64-darwin", "aarch64-macos.11.0", ".dylib"),
)


def compilers() -> dict[Platform, list[str]]:
    """Return platform -> command of its compiler: zig for all, else ``cc`` on Linux on x86-64."""
    if find_spec("ziglang"):
        zig = [sys.executable, "-m", "ziglang", "cc", "-target"]
        return {one: [*zig, one.target] for one in PLATFORMS}
    here = sys.platform == "linux" and platform.machine() == "x86_64"
    tool = shutil.which("cc") if here else None
    return {LINUX: [tool]} if tool else {}


def note() -> str:
    """Return a line on the binaries that FMUs lack here; "": they lack none."""
    if (count := len(compilers())) == len(PLATFORMS):
        return ""
    have = "binaries for Linux on x86-64 only" if count else "no binaries, only their C sources"
    return f'the FMUs contain {have}; for those of other systems: pip install "hfc-design[fmu]"'


def shared_library(sources: Mapping[str, str], name: str, where: Platform = LINUX) -> bytes:
    """Return a library of the ``.c`` files by one of ``compilers()``; RunError: it cannot be."""
    fault = f"cannot compile an FMU for {where.fmi3}"
    with TemporaryDirectory() as folder:
        for file, text in sources.items():
            Path(folder, file).write_bytes(text.encode())
        files = sorted(file for file in sources if file.endswith(".c"))
        result = Path(folder, name + where.ending)
        command = [*compilers()[where], *FLAGS, *files, "-lm", "-o", result.name]
        try:
            done = subprocess.run(
                command, cwd=folder, capture_output=True, timeout=LONGEST_S, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise RunError(f"{command[0]}: {fault}: {error}") from None
        if done.returncode:
            lines = done.stderr.decode(errors="replace").splitlines()
            lines = lines or [f"exit code {done.returncode}"]
            message = next((line for line in lines if "error" in line), lines[0])
            raise RunError(f"{command[0]}: {fault}: {message}")
        return result.read_bytes()
