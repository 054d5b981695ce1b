"""``hfc attainable``, and what a run tells of it: in the terminal, its folder, its page."""

import json

from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.runs.attained import attained_told, kept_attained

SHORT = ["--set", "simulation.duration_s=0.15", "--set", "limits.command=250"]


SLOW = ["--set", "limits.command_rate=500"]


def hfc(*told):
    return CliRunner().invoke(main, told)


def test_a_limit_of_the_rate_is_said_to_be_left_out():
    told = ["attainable", "c-axis-ramp", "--set", "simulation.duration_s=0.02", *SHORT[2:]]
    free, slow = hfc(*told), hfc(*told, *SLOW)
    assert (free.exit_code, slow.exit_code) == (0, 0)
    assert "left out" not in free.stdout
    assert "(left out: limits.command_rate)" in " ".join(slow.stdout.split())
    free, slow = (json.loads(hfc(*told, *more, "--json").stdout) for more in ((), SLOW))
    assert slow == free | {"left_out": "limits.command_rate"}


def test_a_run_with_a_limit_tells_it_and_its_folder_keeps_it(tmp_path, known_use):
    folder = tmp_path / "run"
    few = ["--generations", "2", "--population", "840", "--quiet"]
    done = hfc("design", "c-axis-ramp", *SHORT, *few, "--out", str(folder))
    assert done.exit_code == 0, done.output
    found = kept_attained(folder)
    one = found["motions"]["c-axis-ramp"]
    assert one["simple"] <= one["bound"] <= one["reached"] <= one["sum_error"]
    assert attained_told(found) in done.stdout
    page = (folder / "report.html").read_text()
    assert "How good it could be" in page
    assert f"{one['bound']:.4g}" in page
    again = hfc("attainable", str(folder), "--json")
    assert json.loads(again.stdout) == found
