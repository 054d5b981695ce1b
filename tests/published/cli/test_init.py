"""``hfc init``: what it writes is searched as it is, of every plant."""

import pytest
from run_folders import hfc

from hfc_design.reference.entries import PLANT, things

COUPLED = "five-axis-coupled"


@pytest.mark.parametrize("plant", [one.name for one in things(PLANT) if one.name != COUPLED])
def test_it_can_be_searched_as_it_is(plant, tmp_path, known_use, no_baselines):
    file, out = tmp_path / "mine.toml", tmp_path / "run"
    assert hfc("init", "--plant", plant, "--out", file).exit_code == 0
    few = ("--generations", 2, "--population", 6)
    done = hfc("design", file, *few, "--set", "simulation.duration_s=1.2", "--out", out, "--quiet")
    assert done.exit_code == 0, done.output
    assert (out / "design.json").is_file()


def test_of_coupled_axes_it_is_that_of_the_same_axes_alone(tmp_path):
    """Which is searched above, and whose programs are as dear."""
    alone = COUPLED.removesuffix("-coupled")
    for plant in (alone, COUPLED):
        assert hfc("init", "--plant", plant, "--out", tmp_path / f"{plant}.toml").exit_code == 0
    texts = [(tmp_path / f"{plant}.toml").read_text() for plant in (alone, COUPLED)]
    assert texts[0] == texts[1].replace(COUPLED, alone)
    assert COUPLED in texts[1]
