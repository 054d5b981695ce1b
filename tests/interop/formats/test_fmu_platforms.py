"""Binaries of FMUs for all systems, compiled by zig: what they are, and what they compute.

Those for Windows run under Wine, those for Linux on ARM under QEMU, where these are installed.
"""

import os
import shutil
import struct
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from places import TESTS

from hfc_design.files.loop_setup import load_design
from hfc_design.formats import FORMATS, compiling

pytestmark = pytest.mark.skipif(not find_spec("ziglang"), reason="ziglang is not installed")

#: Folder of FMI 3.0 -> that of FMI 2.0.5, and how such a file begins: ELF with its machine, PE,
#: Mach-O with its processor (System V ABI, Microsoft PE format, Apple's loader.h and machine.h).
FOLDERS = {
    "x86_64-linux": ("linux64", ".so", lambda x: (x[:4], x[18]) == (b"\x7fELF", 62)),
    "aarch64-linux": ("aarch64-linux", ".so", lambda x: (x[:4], x[18]) == (b"\x7fELF", 183)),
    "x86_64-windows": ("win64", ".dll", lambda x: (x[:2], _machine(x)) == (b"MZ", 0x8664)),
    "x86_64-darwin": ("darwin64", ".dylib", lambda x: x[:8] == _macho(0x01000007)),
    "aarch64-darwin": ("aarch64-darwin", ".dylib", lambda x: x[:8] == _macho(0x0100000C)),
}
SAMPLES = 2_000
DESIGNS = ("lin-lee-1999-table-1", "jee-koren-2004-aflc", "emps-cascade")


def _machine(binary):
    (header,) = struct.unpack_from("<I", binary, 0x3C)
    return struct.unpack_from("<4sH", binary, header)[1]


def _macho(processor):
    return struct.pack("<II", 0xFEEDFACF, processor)


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """Design -> folders of the FMUs of its loop of FMI 2.0 and 3.0."""
    folders = {}
    for name in DESIGNS:
        out = tmp_path_factory.mktemp(name)
        FORMATS["fmu-loop"].write(load_design(name), out / "fmu")
        for fmu in sorted((out / "fmu").iterdir()):
            with zipfile.ZipFile(fmu) as archive:
                archive.extractall(out / fmu.stem)
        folders[name] = sorted(x for x in out.iterdir() if x.name != "fmu")
    return folders


@pytest.mark.parametrize("name", DESIGNS)
def test_each_system_has_its_binary_where_the_standard_says(name, unpacked):
    for version, folder in zip((2, 3), unpacked[name], strict=True):
        found = {str(x.relative_to(folder / "binaries")): x for x in folder.glob("binaries/*/*")}
        stem = folder.name.removesuffix(f"_fmi{version}")
        names = {three: two if version == 2 else three for three, (two, *_) in FOLDERS.items()}
        assert set(found) == {f"{names[x]}/{stem}{FOLDERS[x][1]}" for x in FOLDERS}
        for system, (*_, is_one) in FOLDERS.items():
            binary = found[f"{names[system]}/{stem}{FOLDERS[system][1]}"].read_bytes()
            assert is_one(binary), system
            assert f"fmi{version}DoStep".encode() in binary


@pytest.mark.parametrize("where", compiling.PLATFORMS, ids=lambda where: where.fmi3)
def test_no_compiler_warns(where, unpacked, monkeypatch):
    monkeypatch.setattr(compiling, "FLAGS", (*compiling.FLAGS, "-Wall", "-Wextra", "-Werror"))
    for folders in unpacked.values():
        for folder in folders:
            files = (x for x in (folder / "sources").iterdir() if x.suffix != ".xml")
            assert compiling.shared_library({x.name: x.read_text() for x in files}, "x", where)


def test_the_same_bytes_wherever_and_whenever(unpacked, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    folder, _ = unpacked["jee-koren-2004-aflc"]
    files = {x.name: x.read_text() for x in (folder / "sources").iterdir()}
    for where in compiling.PLATFORMS:
        if where.ending != ".dll":  # else zig compiles the C library of Windows again: a minute
            monkeypatch.setenv("ZIG_GLOBAL_CACHE_DIR", str(tmp_path / where.fmi3))  # is empty
        stem = folder.name.removesuffix("_fmi2")
        known = folder / "binaries" / where.fmi2 / f"{stem}{where.ending}"
        assert compiling.shared_library(files, stem, where) == known.read_bytes(), where.fmi3
        monkeypatch.delenv("ZIG_GLOBAL_CACHE_DIR", raising=False)


@pytest.fixture(scope="module")
def loader(tmp_path_factory):
    """The outputs (SAMPLES, outputs) of an FMU of FMI 2.0 on a system, under what emulates it."""
    place = tmp_path_factory.mktemp("loader")

    def run(folder, where, *under):
        program = place / f"load-{where.fmi3}.exe"
        if not program.exists():
            zig = [sys.executable, "-m", "ziglang", "cc", "-target", where.target, "-std=c99"]
            library = [] if where.ending == ".dll" else ["-ldl"]
            source = TESTS / "interop" / "load_fmu.c"
            subprocess.run([*zig, source, *library, "-o", program], check=True)
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        of = {"input": [], "output": []}
        for x in root.iter("ScalarVariable"):
            of.get(x.get("causality"), []).append(x.get("valueReference"))
        every = root.find("DefaultExperiment").get("stepSize")
        (library,) = (folder / "binaries" / where.fmi2).iterdir()
        words = [root.get("guid"), every, str(SAMPLES), *of["input"], "-", *of["output"]]
        own = os.environ | {"WINEPREFIX": str(place / "wine"), "WINEDEBUG": "-all"}
        command = [*under, program, library, *words]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=own)
        rows = [[int(x, 16) for x in line.split()] for line in done.stdout.splitlines()]
        return np.array(rows, np.uint64).view(float)

    return run


@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.parametrize(
    ("system", "tool", "options"),
    [
        ("x86_64-windows", "wine", ()),
        ("aarch64-linux", "qemu-aarch64", ("-L", "/usr/aarch64-linux-gnu")),
    ],
)
def test_another_system_computes_what_this_one_does(name, system, tool, options, unpacked, loader):
    if shutil.which(tool) is None or (options and not Path(options[-1]).exists()):
        pytest.skip(f"{tool} is not installed")
    folder, _ = unpacked[name]
    where = next(x for x in compiling.PLATFORMS if x.fmi3 == system)
    here, there = loader(folder, compiling.LINUX), loader(folder, where, tool, *options)
    assert here.shape == there.shape == (SAMPLES, here.shape[1])
    assert np.ptp(here, axis=0).all(), np.ptp(here, axis=0)
    assert (np.abs(there - here).max(axis=0) <= 1e-12 * np.abs(here).max(axis=0)).all()
