"""``hfc init``: what it writes loads, runs and explains every key."""

import subprocess
import sys

import pytest
from run_folders import hfc

from hfc_design.files.named_scenario import load_scenario
from hfc_design.reference.entries import PLANT, things

#: Each takes half a minute: one is enough every day.
PLANTS = [
    pytest.param(name, marks=[pytest.mark.slow] if name != "c-axis" else [])
    for name in (one.name for one in things(PLANT))
]


@pytest.mark.parametrize("plant", PLANTS)
def test_it_can_be_searched_as_it_is(plant, tmp_path):
    file, out = tmp_path / "mine.toml", tmp_path / "run"
    assert hfc("init", "--plant", plant, "--out", file).exit_code == 0
    few = ("--generations", 2, "--population", 6)
    done = hfc("design", file, *few, "--set", "simulation.duration_s=1.2", "--out", out, "--quiet")
    assert done.exit_code == 0, done.output
    assert (out / "design.json").is_file()


@pytest.mark.parametrize("kind", ["pid", "pid+ff", "lqr", "fuzzy-sliding"])
def test_other_controllers(kind, tmp_path):
    file = tmp_path / "mine.toml"
    done = hfc("init", "--plant", "positioning-stage", "--controller", kind, "--out", file)
    assert done.exit_code == 0, done.output
    assert load_scenario(str(file)).controller.kind == kind


def test_it_starts_no_jax(tmp_path):
    code = f"""
import sys
from hfc_design.cli import main
main(["init", "--out", {str(tmp_path / "mine.toml")!r}], standalone_mode=False)
assert "jax" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
