"""The wheel holds the package, all of it and nothing else, and comes out the same twice."""

import os
import subprocess
import sys
import zipfile

import pytest
from places import ROOT

TREE = ROOT


def wheel(folder):
    """The wheel that the build backend makes of this tree."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    environment = os.environ | {"SOURCE_DATE_EPOCH": "1700000000"}
    subprocess.run(command, cwd=TREE, env=environment, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


def test_the_wheel_is_the_same_twice_and_holds_the_package(tmp_path):
    pytest.importorskip("hatchling", reason="the build backend is not installed")
    one, two = (wheel(tmp_path / name) for name in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()
    names = set(zipfile.ZipFile(one).namelist())
    package = {
        path.relative_to(TREE).as_posix()
        for top in ("hfc_design", "plants")
        for path in (TREE / top).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    about = {name for name in names if name.split("/")[0].endswith(".dist-info")}
    assert names - about == package
    assert {"hfc_design/py.typed", "plants/py.typed"} < names  # others check types against it
    assert {name.split("/", 1)[1] for name in about} == {
        "METADATA",
        "RECORD",
        "WHEEL",
        "entry_points.txt",
        "licenses/LICENSE",
    }
