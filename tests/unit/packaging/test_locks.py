"""Every package that the environments are made of is pinned with hashes, and no address with it."""

import ast
import os
import re
import subprocess
import sys
import tomllib
import zipfile

import pytest
from places import ROOT

TREE = ROOT
LOCKS = sorted((TREE / "requirements").glob("*.txt"))
PROJECT = tomllib.loads((TREE / "pyproject.toml").read_text())


def pinned(lock):
    """(name, version, number of hashes) of every entry of a lock."""
    entries = re.split(r"\n(?=\S)", re.sub(r"(?m)^#.*\n", "", lock.read_text()))
    for entry in entries:
        name, version = re.match(r"([\w.-]+)==([\w.]+)[ \n]", entry).groups()
        yield name, version, len(re.findall(r"--hash=sha256:[0-9a-f]{64}", entry))


def bare(requirement):
    """The name of a requirement as locks write it."""
    return re.split(r"[\[<>=~ ]", requirement)[0].lower().replace("_", "-")


@pytest.mark.parametrize("lock", LOCKS, ids=lambda lock: lock.stem)
def test_each_is_pinned_with_hashes(lock):
    assert "//" not in lock.read_text()
    for name, _, hashes in pinned(lock):
        assert hashes, name


def test_the_locks_hold_what_the_project_asks_for():
    extras = PROJECT["project"]["optional-dependencies"]
    direct = PROJECT["project"]["dependencies"]
    build = PROJECT["dependency-groups"]["build"]
    peers = direct + extras.pop("peers") + build
    assert extras.pop("fmu") == ["ziglang>=0.14"]  # half a gigabyte, which is not pinned
    tools = [*(one for extra in extras.values() for one in extra), *build]
    wanted = {"runtime": direct, "locked": direct + tools, "lowest": direct + tools, "peers": peers}
    for stem, requirements in wanted.items():
        names = {name for name, _, _ in pinned(TREE / "requirements" / f"{stem}.txt")}
        assert {bare(one) for one in requirements} - {"hfc-design"} <= names, stem
    locked = set(pinned(TREE / "requirements" / "locked.txt"))
    runtime = set(pinned(TREE / "requirements" / "runtime.txt"))
    assert runtime <= locked
    assert runtime <= set(pinned(TREE / "requirements" / "peers.txt"))


def test_the_build_backend_is_one():
    (backend,) = PROJECT["build-system"]["requires"]
    assert backend in PROJECT["dependency-groups"]["build"]
    assert backend in (TREE / "requirements" / "tools.in").read_text().splitlines()
    name, version = backend.split("==")
    for stem in ("locked", "lowest", "peers", "tools"):
        assert (name, version) in {one[:2] for one in pinned(TREE / "requirements" / f"{stem}.txt")}


def test_the_lowest_are_those_of_the_project():
    lowest = {}  # one of them where a newer Python needs a newer one
    for name, version, _ in pinned(TREE / "requirements" / "lowest.txt"):
        lowest.setdefault(name, version)
    for requirement in PROJECT["project"]["dependencies"]:
        name, bound = requirement.split(">=")
        assert (lowest[bare(name)] + ".").startswith(bound + "."), requirement


PAGE = (ROOT / "docs" / "development.md").read_text("utf-8")


def listed():
    """Folders and files of the package in the order in which the page tells of them."""
    table = PAGE.partition("## What is where")[2].partition("Imports run down")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    names = re.findall(r"`([\w/]+)(?:\.py)?`", "".join(rows))
    package = [name.removeprefix("hfc_design/").strip("/") for name in names]
    return package[: package.index("api") + 1]


def imported(file):
    """What of ours a file imports anywhere in it: names of folders, or of files at the top."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        for name in names:
            first, *rest = name.split(".")
            if first == "plants":
                yield first
            elif first == "hfc_design" and rest[0] != "__version__":
                yield rest[0]


def test_nothing_imports_what_comes_later():
    order = listed()
    assert order[:2] == ["plants", "core"]
    files = [*(ROOT / "plants").rglob("*.py"), *(ROOT / "hfc_design").rglob("*.py")]
    seen = set()
    for file in files:
        first, second, *_ = file.relative_to(ROOT).parts
        own = first if first == "plants" else second.removesuffix(".py")
        if own.startswith("__"):
            continue
        seen.add(own)
        for other in imported(file):
            assert order.index(other) <= order.index(own), f"{file} imports {other}"
    assert seen == set(order)


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
