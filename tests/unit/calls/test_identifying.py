"""A log that SciPy made of a plant of one's own, identified by a script as by the command."""

import sys

import numpy as np
import pytest
from scipy.signal import cont2discrete, dlsim
from sledge import MODULE

import hfc_design.api as hfc

TIME = 1e-3 * np.arange(2000)
FORCE = 40.0 * np.sin(5.0 * TIME) + 25.0 * np.sin(23.0 * TIME + 1.0)  # [N]
TRUE = {"mass": 5.0, "friction": 9.0}


@pytest.fixture(autouse=True)
def log(own_plugins, tmp_path, monkeypatch):
    """A mass of 5 kg against 9 N s/m, measured with 2 um of noise."""
    monkeypatch.chdir(tmp_path)
    sys.path.insert(0, str(tmp_path))
    (tmp_path / "mine.py").write_text(MODULE)
    rates = np.array([[0.0, 1.0], [0.0, -TRUE["friction"] / TRUE["mass"]]])
    parts = (
        rates,
        np.array([[0.0], [1.0 / TRUE["mass"]]]),
        np.array([[1.0, 0.0]]),
        np.zeros((1, 1)),
    )
    place = dlsim(cont2discrete(parts, 1e-3), FORCE)[1][:, 0]
    place += np.random.default_rng(0).normal(0.0, 2e-6, len(TIME))
    head, columns = "time_s,place_m,command_N", np.stack([TIME, place, FORCE], axis=1)
    np.savetxt("log.csv", columns, "%.12g", ",", header=head, comments="")


def test_mistakes_are_told_as_the_command_tells_them():
    with pytest.raises(hfc.UserError, match="mas: sledge has no such parameter; did you mean mass"):
        hfc.identify("log.csv", "mine:SLEDGE", free=["mas"])
    with pytest.raises(hfc.UserError, match="which machine is it"):
        hfc.identify("log.csv")
    with pytest.raises(hfc.UserError, match="speed: is no signal of"):
        hfc.identify("log.csv", "c-axis", columns=["speed=q"])
    with pytest.raises(hfc.UserError, match="an int is no path"):
        hfc.identify(3, "c-axis")
