"""Command lines that are refused, of designs whose reading computes: one line each."""

import json
import re
import shlex
import shutil
from shlex import split

import pytest
from doc_pages import ROOT
from run_folders import hfc
from wording import refused_command

from hfc_design.files.design import BUILTIN

LL, JK = "lin-lee-1999-table-1", "jee-koren-2004"
#: Command line -> what its refusal begins with.
MISTAKES = {
    "attainable feed-drive-circle": "scenario feed-drive-circle",
    f"attainable c-axis-ramp --set limits.command=250 --design {JK}-pid": f"design {JK}-pid",
    "compare pd-only": "needs at least two designs",
    "compare pd-only pd-only": "pd-only",
    "compare pd-only none": "none",
    "compare pd-only pid": "pid",
    f"compare {LL} pd-only --scenario feed-drive-circle": f"design {LL}",
    f"compare {LL} pd-only --scenario none": "none",
    f"compare {LL} pd-only --out x --html x": "--html x",
    f"compare {LL} pd-only --set sensors.x=1": "c-axis-ramp",
    "design feed-drive-contour --set controller.start=jee-koren-2004-flc": "feed-drive-contour",
    "plot pd-only terms --out a.png": "design pd-only",
    f"plot {LL} surface --unit unit-9 --out a.png": "--unit",
    f"plot {LL} tree --out a.gif": "a.gif",
    f"plot {LL} tree --width 5mm --out b.svg": "--width",
    "plot huang-cross-coupled surface --out a.png": "design huang-cross-coupled-x",
    "plot pd-only motion --out a.png": "motion draws several designs; for one use hfc simulate",
    f"plot pd-only {LL} tree --out a.png": "tree",
    "plot pd-only pd-only motion --out a.png": "pd-only",
    f"plot pd-only {JK}-flc motion --out a.png": f"design {JK}-flc",
    "plot pd-only tree --motion creep --out a.png": "--motion",
    f"plot pd-only {LL} motion --unit x --out a.png": "--unit",
    "plot pd-only convergence --out a.png": "pd-only",
    f"simulate {JK}-flc --learned a.json": f"design {JK}-flc",
    f"simulate {LL} --learned a.json": f"design {LL}",
    "score pd-only --scenario c-axis-ramp --scenario feed-drive-circle": "design pd-only",
    "score pd-only --scenario c-axis-practical --set simulation.sample_time_s=0.002": "design",
}


@pytest.mark.parametrize("command", MISTAKES)
def test_a_mistake_is_a_line_and_nothing_is_written(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = refused_command(*split(command))
    assert line.startswith(f"hfc: {MISTAKES[command]}")
    assert line.count("\n") == 1
    assert [*tmp_path.iterdir()] == []


SHORT = ["--set", "simulation.duration_s=0.1", "--machines", "4"]


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


DOCS = ROOT / "docs"
MESSAGES = re.findall(
    r"^\| `(hfc [^`]*)` \| `([^`]*)` \|", (DOCS / "questions.md").read_text("utf-8"), re.MULTILINE
)


@pytest.mark.parametrize(("command", "says"), MESSAGES, ids=[one[1] for one in MESSAGES])
def test_messages_are_those_of_the_program(command, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = hfc(*shlex.split(command)[1:])
    assert done.exit_code in (1, 2)
    assert len(done.stderr.splitlines()) == 1
    assert says in done.stderr


def test_the_table_of_errors_is_read():
    assert len(MESSAGES) == 10
