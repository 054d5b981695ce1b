"""Every package that the environments are made of is pinned with hashes, and no address with it."""

import re
import tomllib

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
