"""``hfc attainable``, and what a run tells of it: in the terminal, its folder, its page."""

import json

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.runs.attained import ATTAINABLE, attained_rows, attained_told, kept_attained

SHORT = ["--set", "simulation.duration_s=0.3", "--set", "limits.command=250"]


SLOW = ["--set", "limits.command_rate=500"]


def hfc(*told):
    return CliRunner().invoke(main, told)


@pytest.mark.parametrize(
    ("told", "why"),
    [
        (["c-axis-ramp"], "has no limits.command"),
        (["feed-drive-circle"], "bounds are of machines of one c-axis only"),
        (["nowhere"], "nowhere: no such scenario"),
        (["c-axis-ramp", *SHORT, "--design", "jee-koren-2004-pid"], "jee-koren-2004-pid"),
    ],
)
def test_bad_input_is_one_line(told, why):
    result = hfc("attainable", *told)
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert line.startswith("hfc: ")
    assert why in line


def test_rows_and_the_line_of_a_design():
    one = {"bound": 0.02, "reached": 0.025, "sum_error": 0.05, "simple": 0.01, "samples": 9}
    found = {"unit": "rad", "motions": {"ramp": one}}
    assert attained_rows(found) == [["ramp", "0.02", "0.025", "0.05", "2.5", "2"]]
    assert attained_told(found) == (
        "sum |e| 0.05 rad: 2.5 times the certified bound 0.02, "
        "2 times the best open-loop voltage 0.025"
    )
    slow = attained_told(found | {"left_out": "limits.command_rate"})
    assert slow.endswith("the best open-loop voltage 0.025 (limits.command_rate is left out)")
    lost = {"motions": {"ramp": one | {"sum_error": None}}}
    assert attained_rows(lost) == [["ramp", "0.02", "0.025", "–", "–", "–"]]
    assert attained_told(lost) == ""
    nothing = {"motions": {"ramp": one | {"bound": 0.0, "reached": 0.0}}}
    assert attained_rows(nothing) == [["ramp", "0", "0", "0.05", "–", "–"]]


def test_a_limit_of_the_rate_is_said_to_be_left_out():
    told = ["attainable", "c-axis-ramp", "--set", "simulation.duration_s=0.02", *SHORT[2:]]
    free, slow = hfc(*told), hfc(*told, *SLOW)
    assert (free.exit_code, slow.exit_code) == (0, 0)
    assert "left out" not in free.stdout
    assert "(limits.command_rate is left out)" in " ".join(slow.stdout.split())
    free, slow = (json.loads(hfc(*told, *more, "--json").stdout) for more in ((), SLOW))
    assert slow == free | {"left_out": "limits.command_rate"}


def test_a_file_that_was_edited_is_no_answer(tmp_path):
    for text in ("", "{", "[]", '{"motions": 3}', '{"motions": {"ramp": {"bound": "no"}}}'):
        (tmp_path / ATTAINABLE).write_text(text)
        assert kept_attained(tmp_path) is None
    assert kept_attained(tmp_path / "nowhere") is None


@pytest.mark.slow
def test_a_run_with_a_limit_tells_it_and_its_folder_keeps_it(tmp_path):
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
