"""``hfc identify`` as a user calls it, on logs that SciPy made of plants without secrets."""

import os
import sys

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.signal import cont2discrete, dlsim
from sledge import MODULE

from hfc_design.cli import main

EVERY = 1e-3
TIME = EVERY * np.arange(3000)
FORCE = 40.0 * np.sin(5.0 * TIME) + 25.0 * np.sin(23.0 * TIME + 1.0)  # [N]


def moved(mass, friction, force=FORCE, noise=2e-6, seed=0):
    """(steps,) where a mass goes under a force against viscous friction [m], measured."""
    rates = np.array([[0.0, 1.0], [0.0, -friction / mass]])
    parts = (rates, np.array([[0.0], [1.0 / mass]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)))
    place = dlsim(cont2discrete(parts, EVERY), force)[1][:, 0]
    return place + np.random.default_rng(seed).normal(0.0, noise, len(force))


def write(name, head, *columns):
    np.savetxt(name, np.stack([TIME, *columns], axis=1), "%.12g", ",", header=head, comments="")


def identify(*arguments):
    found = CliRunner().invoke(main, ["identify", *map(str, arguments)])
    assert found.exit_code == 0, found.output
    return found.stdout


@pytest.fixture(autouse=True)
def folder(own_plugins, tmp_path, monkeypatch):
    """A folder with a module of one's own; the plant SLEDGE has a mass of 2, a friction of 3."""
    monkeypatch.chdir(tmp_path)
    sys.path.insert(0, str(tmp_path))
    (tmp_path / "mine.py").write_text(MODULE)


def test_a_plant_that_branches_is_refused_in_a_line():
    write("log.csv", "time_s,place_m,command_N", moved(5.0, 9.0), FORCE)
    found = CliRunner().invoke(main, ["identify", "log.csv", "--plant", "mine:BRANCHING"])
    assert found.exit_code == 2
    last = found.stderr.splitlines()[-1]
    assert last.startswith("hfc: plant 'sledge' cannot be replayed: in mine.py, line ")
    assert last.endswith("(TracerBoolConversionError)")
    assert "Traceback" not in found.output
    assert set(os.listdir()) <= {"__pycache__", "log.csv", "mine.py"}
