"""What made a checkpoint: another version, file or own part does not go on unasked."""

import importlib.metadata
import json
import shutil

import numpy as np
import pytest
from batches import batch, files, left_behind, written
from run_folders import hfc
from short_runs import SMALL, resumed, stopping
from wording import refused, refused_command

from hfc_design.core import archive
from hfc_design.core.records import RunError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design
from hfc_design.runs import stored

WAY = "time_s,reference_rad\n0,0\n0.05,0.001\n0.1,0.0015\n"
MADE = ("design.json", "history.csv", "checkpoint.npz")


def contents(folder):
    return {name: (folder / name).read_bytes() for name in MADE}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A run that names a file, whole and broken off."""
    path = tmp_path_factory.mktemp("stored")
    (path / "way.csv").write_text(WAY)
    (path / "mine.toml").write_text('reference = {kind = "csv", file = "way.csv"}\n')
    scenario = load_scenario(str(path / "mine.toml"), SMALL)
    whole, part = path / "whole", path / "part"
    design.run(design.new_run(scenario, whole), whole)
    stopping(design.new_run(scenario, part), part, 2)
    return whole, part


@pytest.fixture
def both(made, tmp_path):
    """The whole one, and a copy of the other."""
    return made[0], shutil.copytree(made[1], tmp_path / "part")


def test_a_checkpoint_says_what_made_it(both):
    whole, _ = both
    told = json.loads(str(archive.unpacked((whole / "checkpoint.npz").read_bytes())["made_by"]))
    wanted = ["config.toml", "reference.csv", "hfc-design", "jax", "jaxlib", "numpy", "scipy"]
    assert list(told) == wanted
    assert told["jax"] == importlib.metadata.version("jax")


@pytest.mark.parametrize("package", ["jax", "jaxlib", "numpy", "scipy"])
def test_another_version_goes_on_only_anyway(package, both, monkeypatch):
    whole, part = both
    before = (part / "checkpoint.npz").read_bytes()
    now = importlib.metadata.version(package)
    real = stored.version
    with monkeypatch.context() as patch:
        patch.setattr(stored, "version", lambda name: "9.8.7" if name == package else real(name))
        told = hfc("design", "--resume", "--out", part, "--quiet")
        assert told.exit_code == 1
        which = f"belongs to a run with another {package} ('{now}', here '9.8.7')"
        assert which in told.stderr
        assert "; to continue nevertheless add --anyway" in told.stderr
        assert len(told.stderr.splitlines()) == 1
        assert (part / "checkpoint.npz").read_bytes() == before
        design.finished_run(whole)  # is only read
        design.run(design.opened_run(part), part, anyway=True)
    assert contents(part)["design.json"] == contents(whole)["design.json"]
    assert contents(part)["history.csv"] == contents(whole)["history.csv"]
    told = archive.unpacked((part / "checkpoint.npz").read_bytes())["made_by"]
    assert json.loads(str(told))[package] == "9.8.7"


def test_another_file_beside_it(both):
    whole, part = both
    (part / "reference.csv").write_text(WAY.replace("0.0015", "0.0016"))
    with refused(RunError) as found:
        resumed(part)
    assert found.where == str(part / "checkpoint.npz")
    (part / "reference.csv").write_text(WAY)
    resumed(part)
    assert contents(part) == contents(whole)


def test_a_run_that_is_to_be_longer(both):
    _, part = both
    text = (part / "config.toml").read_text()
    (part / "config.toml").write_text(text.replace("generations = 5", "generations = 7"))
    with pytest.raises(RunError, match=r"another config\.toml"):
        resumed(part)
    design.run(design.opened_run(part), part, anyway=True)
    assert len((part / "history.csv").read_text().splitlines()) == 1 + 7


def test_anyway_is_for_resuming():
    refused_command("design", "--anyway", "--quiet")


def test_cells_of_another_version_fail_until_anyway(tmp_path, monkeypatch):
    text = (
        "[set]\nsearch.population = 12\nsearch.generations = 4\nsimulation.duration_s = 0.1\n"
        "controller.kind = 'pd'\n[grid]\nrun.seed = [0, 1]\n"
    )
    undisturbed = left_behind(tmp_path, text)
    out = tmp_path / "out"
    broken_off = sorted(path for path in out.iterdir() if (path / "design.json").exists())[0]
    (broken_off / "design.json").unlink()
    real = stored.version
    patch = pytest.MonkeyPatch()
    patch.setattr(stored, "version", lambda name: "9.8.7" if name == "jax" else real(name))
    told = batch(written(tmp_path, text), "--out", out)
    assert told.exit_code == 1
    assert "another jax" in told.stderr
    assert "another jax" in " ".join(batch("--status", out).output.split())
    assert batch(written(tmp_path, text), "--out", out, "--anyway").exit_code == 0
    patch.undo()
    now = files(out)
    own = f"{broken_off.name}/checkpoint.npz"
    assert now.pop(own) != undisturbed.pop(own)  # says so
    assert now == undisturbed


def test_what_killed_processes_left_goes_at_the_next_run(both):
    whole, part = both
    (part / ".hfc-0123456789abcdef.new").write_bytes(b"half")
    (part / "mine.new").write_bytes(b"a user's own")
    resumed(part)
    assert contents(part) == contents(whole)
    assert not (part / ".hfc-0123456789abcdef.new").exists()
    assert (part / "mine.new").exists()


def test_a_finished_run_of_an_earlier_version_is_read(both, tmp_path):
    whole, _ = both
    arrays = archive.unpacked((whole / "checkpoint.npz").read_bytes())
    old = tmp_path / "old"
    shutil.copytree(whole, old)
    del arrays["made_by"]
    config = (whole / "config.toml").read_text()
    told = {"format": np.array("hfc-checkpoint-2"), "config": np.array(config)}
    np.savez(old / "checkpoint.npz", **{**arrays, **told})
    scenario, result = design.finished_run(old)
    assert result.search.generation == 5
    assert result.design == design.finished_run(whole)[1].design
    with refused(RunError):
        design.run(scenario, old)
    design.run(scenario, old, anyway=True)
    assert contents(old) == contents(whole)


def test_another_version_of_the_package(both, monkeypatch):
    _, part = both
    monkeypatch.setattr(stored, "__version__", "7.0")
    with pytest.raises(RunError, match=r"another hfc-design \('.*', here '7.0'\)"):
        resumed(part)
