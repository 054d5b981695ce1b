"""A feed drive of one axis: columns, metrics, pictures in its own units; whole commanded BLU."""

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.report.verdict import BASELINES, Baseline

SCENARIO = """
[plant]
name = "feed-drive"

[reference]
kind = "ramp"
velocity = 333.0

[simulation]
duration_s = 0.5
sample_time_s = 0.01
substeps = 4

[load]
constant = 1.0

[controller]
inputs = [{ name = "error", scale = 0.05 }, { name = "velocity", scale = 0.0005 }]
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("one-axis") / "one-axis.toml"
    path.write_text(SCENARIO)
    return path


def hfc(*arguments):
    done = CliRunner().invoke(main, [str(item) for item in arguments])
    assert done.exit_code == 0, done.output
    return done.stdout


def test_a_run_designs_for_one_axis_and_reports_in_its_units(scenario, tmp_path, monkeypatch):
    rival = {"jee-koren-2004-pid": Baseline("JK04 PID")}  # the others take long to compile
    monkeypatch.setitem(BASELINES, "feed-drive", rival)
    folder = tmp_path / "run"
    sizes = ["--population", "24", "--generations", "2"]
    hfc("design", scenario, *sizes, "--out", folder, "--quiet")
    page = (folder / "report.html").read_text()
    assert "largest command [unit]" in page
    assert "jee-koren-2004-pid" in page
    assert "voltage" not in page
    assert "rad]" not in page
    text = hfc("simulate", folder, "--plot", tmp_path / "a.png")
    assert text.split() == [str(tmp_path / "a.png")]
