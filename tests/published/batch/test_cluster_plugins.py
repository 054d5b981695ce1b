"""Own plants, fitnesses and laws on worker processes: only their names are sent."""

import json
import re
import subprocess
import sys

import pytest
from batches import batch, files, written
from dask_cluster import ENVIRONMENT, ended
from sledge import MODULE, SCENARIO, installed, package

#: A plant, a fitness and a law of the user's own, by their names only.
SLEDGE = f"""{SCENARIO}
[fitness]
kind = "last-error"
[controller]
kind = "only-p"
"""
SLEDGES = """
[set]
search.population = 4
search.generations = 1
[grid]
scenario = ["sledge.toml"]
run.seed = [0, 1]
"""


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """What the grid of plug-ins leaves behind without workers.

    A process of its own makes it: this one must not know the plug-ins.
    """
    path = tmp_path_factory.mktemp("plain")
    command = [sys.executable, "-m", "hfc_design", "batch", "mine.toml", *sledges(path, "mine")]
    subprocess.run(command, check=True, cwd=path, env=ENVIRONMENT)
    return files(path / "runs" / "mine")


def sledges(path, module):
    """Make the grid in ``path`` one of plug-ins of a module there; returns the options for it."""
    (path / f"{module}.py").write_text(MODULE)
    written(path, SLEDGE, "sledge.toml")
    written(path, SLEDGES)
    objects = {"plant": "SLEDGE", "fitness": "LAST", "controller": "P"}
    return [text for key, name in objects.items() for text in (f"--{key}", f"{module}:{name}")]


def apart(found, module):
    """The files without what designs say of their plug-ins, which lie in ``module``."""
    rest = dict(found)
    for name in found:
        if name.endswith("design.json"):
            rest[name] = json.loads(found[name])
            assert rest[name]["provenance"].pop("plugins") == {
                "plant": {"sledge": f"{module}:SLEDGE"},
                "fitness": {"last-error": f"{module}:LAST"},
                "controller": {"only-p": f"{module}:P"},
            }
    return rest


@pytest.fixture
def asked(tmp_path, cluster, own_plugins, monkeypatch):
    """Call ``hfc batch`` on the grid for workers elsewhere: (exit code, what it says)."""
    monkeypatch.chdir(tmp_path)

    def call(*options):
        found = batch("mine.toml", "--out", "out", "--scheduler", cluster.up(), *options)
        lines = found.stderr.splitlines()
        return found.exit_code, [
            line for line in lines if line.split()[0] not in ("cell", "waiting")
        ]

    return call


def test_workers_elsewhere_need_the_package(tmp_path, plain, asked, cluster):
    """Without its entry points they import no module, even if it is there."""
    sledges(tmp_path, "packaged")
    (cluster.path / "packaged.py").write_text(MODULE)
    points = (
        "[hfc_design.plants]",
        "sledge = packaged:SLEDGE",
        "[hfc_design.fitness]",
        "last-error = packaged:LAST",
        "[hfc_design.controllers]",
        "only-p = packaged:P",
    )
    installed(tmp_path, *points)
    code, said = asked()
    assert (code, len(said)) == (1, 3), said
    for part in ("the worker tcp://", "plant.name = 'sledge'", "unknown plant"):
        assert part in said[0]
    package(cluster.path, *points)
    assert asked() == (0, [])
    assert apart(files(tmp_path / "out"), "packaged") == apart(plain, "mine")


def test_workers_of_our_own_know_a_module_of_the_current_folder(tmp_path, plain, started):
    assert len([name for name in plain if name.endswith("design.json")]) == 2
    assert ended(started("--workers", "1", *sledges(tmp_path, "here"))) == (0, [])
    assert apart(files(tmp_path / "out"), "here") == apart(plain, "mine")


def test_workers_elsewhere_need_the_module(tmp_path, plain, asked, cluster):
    """Only its name is sent to them."""
    options = sledges(tmp_path, "there")
    code, said = asked(*options)
    assert (code, len(said)) == (1, 3), said
    for line in said[:2]:
        assert re.search(r"the worker tcp://127\.0\.0\.1:\d+ on \S", line)
        assert re.search(r"--(plant there:SLEDGE|fitness there:LAST|controller there:P):", line)
        for part in ("No module named 'there'", "install the module"):
            assert part in line
    (cluster.path / "there.py").write_text(MODULE)
    assert asked(*options, "--shared") == (0, [])
    assert apart(files(tmp_path / "out"), "there") == apart(plain, "mine")
