"""``hfc compare`` as a user meets it."""

import json
import shutil

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.design import BUILTIN

SHORT = ["--set", "simulation.duration_s=0.3", "--machines", "6"]
TWO = ["lin-lee-1999-table-1", "pd-only"]


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_run_folders_and_files_of_one_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        folder = tmp_path / "runs" / name
        folder.mkdir(parents=True)
        shutil.copy(BUILTIN / "pd-only.json", folder / "design.json")
    found = hfc("compare", "runs/one", "runs/two", *SHORT, "--json")
    assert found.exit_code == 0, found.output
    numbers = json.loads(found.stdout)
    assert numbers["designs"] == ["one", "two"]
    assert all(one["p"] == 1.0 and one["ratio"] == 1.0 for one in numbers["differences"])


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "needs two designs at least"),
        (["pd-only"], "needs two designs at least"),
        (["pd-only", "pd-only"], "pd-only: stands there twice"),
        (["pd-only", "none"], "none: no such design"),
        (["pd-only", "pid"], "pid: is a kind of controller"),
        (["pid", "pd-only"], "pid: is a kind of controller"),
        (["pd-only", "jee-koren-2004-pid"], "is for the plant feed-drive"),
        ([*TWO, "--scenario", "feed-drive-circle"], "is for the plant c-axis"),
        ([*TWO, "--scenario", "none"], "none: no such scenario"),
        ([*TWO, "--spread", "1.5"], "--spread 1.5: has to lie between 0 and 1"),
        ([*TWO, "--machines", "0"], "--machines"),
        ([*TWO, "--out", "x", "--html", "x"], "--out names it too"),
        ([*TWO, "--set", "sensors.x=1"], "sensors.x"),
    ],
)
def test_mistakes_are_a_line(arguments, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = hfc("compare", *arguments)
    assert found.exit_code == 2
    assert told in found.stderr
    assert "Traceback" not in found.output
    assert list(tmp_path.iterdir()) == []
