"""What the terminal says of whether a design can be used: the table, the picture, one motion."""

import json
import re

import numpy as np
import pytest
from run_folders import hfc
from wording import refused_command

from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate

MOTIONS = """
[simulation]
duration_s = 0.1
[fitness]
settled_after_s = 0.06
[[motions]]
name = "ramp"
[[motions]]
name = "creep"
reference = { kind = "ramp", velocity = 0.002 }
duration_s = 0.08
"""


@pytest.fixture
def two(tmp_path):
    """A scenario of two motions without tolerances."""
    (tmp_path / "two.toml").write_text(MOTIONS)
    return tmp_path / "two.toml"


def test_one_motion_of_several_is_simulated(two, tmp_path):
    done = hfc("simulate", "pd-only", "--scenario", two, "--motion", "creep")
    assert done.exit_code == 0, done.output
    names, *rows = done.stdout.splitlines()
    columns = dict(
        zip(names.split(","), np.array([r.split(",") for r in rows], float).T, strict=True)
    )
    scenario = load_scenario(str(two))
    (axis,) = evaluate("pd-only", scenario).motions["creep"].axes
    np.testing.assert_array_equal(columns["error_rad"], axis.motion.error)
    assert columns["reference_rad"][-1] == pytest.approx(0.002 * 0.079)
    first = hfc("simulate", "pd-only", "--scenario", two).stdout
    assert first == hfc("simulate", "pd-only", "--scenario", two, "--motion", "ramp").stdout
    assert first != done.stdout
    drawn = ["--motion", "creep", "--plot", tmp_path / "c.png"]
    assert hfc("simulate", "pd-only", "--scenario", two, *drawn).exit_code == 0
    assert (tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")
    scored = hfc("score", "pd-only", "--scenario", two, "--motion", "creep", "--json").stdout
    assert json.loads(scored)["max_error_rad"] == max(abs(columns["error_rad"]))
    for name, scene in (("crawl", two), ("creep", "c-axis-ramp")):
        lost = refused_command("simulate", "pd-only", "--scenario", scene, "--motion", name)
        assert lost.where == f"--motion {name}"


def test_a_loop_that_is_off_again_and_again_settles_never():
    """The error of a PD follows the acceleration of a sine to the last sample."""
    done = hfc(
        "score", "pd-only", "--scenario", "c-axis-sine", "--set", "simulation.duration_s=0.2"
    )
    assert re.search(r"settling_time_s +│ +never │", done.stdout), done.output
