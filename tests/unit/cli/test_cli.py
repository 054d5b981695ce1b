"""The command line as a user meets it."""

import csv
import io
import os
import re
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from imported_files import PYFUZZYLITE
from places import ROOT
from run_folders import hfc
from wording import refused_command

from hfc_design.cli.search_progress import Watch
from hfc_design.files.design import builtin_designs
from hfc_design.files.named_scenario import builtin_names, load_scenario
from hfc_design.formats import writing


def test_help_lists_the_commands_as_their_page_introduces_them():
    page = (ROOT / "docs" / "commands.md").read_text()
    introduced = dict.fromkeys(re.findall(r"^hfc (\w+)", page, re.MULTILINE))
    listed = hfc("--help").stdout.split("Commands:")[1]
    assert re.findall(r"^  (\w+) ", listed, re.MULTILINE) == list(introduced)


def test_an_interrupt_that_a_library_tells_as_a_fault_of_its_own_is_one(monkeypatch):
    """As JAX does while it is imported."""

    def broken(*_, **__):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        raise ImportError("initialization failed")

    monkeypatch.setattr("hfc_design.files.named_scenario.load_scenario", broken)
    stopped = hfc("design")
    assert (stopped.exit_code, stopped.output.strip()) == (1, "Aborted!")


def test_export_csv_tables(tmp_path):
    path = tmp_path / "tables"
    assert hfc("export", "lin-lee-1999-table-2", "--to", "csv", "--out", path).exit_code == 0
    with (path / "manifest.csv").open(newline="") as file:
        manifest = list(csv.DictReader(file))
    assert [row["unit"] for row in manifest] == ["unit-3", "unit-1", "unit-2", "unit-0"]
    with (path / manifest[0]["file"]).open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == [
        "row previous_spindle_velocity \\ column error",
        *(f"f{k}" for k in range(1, 8)),
    ]
    assert float(rows[2][2]) == 1.7120  # Table II(a): row f2, column f2
    refused = refused_command("export", "lin-lee-1999-table-2", "--to", "csv", "--out", path)
    assert refused.where == f"--out {path}"


@pytest.mark.parametrize(
    ("what", "names"),
    [
        ("scenarios", builtin_names()),
        ("designs", builtin_designs()),
        ("plants", ["c-axis"]),
        ("controllers", ["pd", "pd+hierarchical-fuzzy"]),
        ("formats", ["json", "csv"]),
    ],
)
def test_lists(what, names):
    done = hfc("list", what)
    assert done.exit_code == 0
    for name in names:
        assert name in done.stdout


PD = "pd-only"


def test_a_pipe_or_a_device_is_never_replaced_by_a_file(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert refused_command("simulate", PD, "--csv", pipe, "--force").where == f"--csv {pipe}"
    assert pipe.is_fifo()


def test_the_names_that_commands_choose_are_not_overwritten_either(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for command in (("export", PD, "--to", "json"), ("import", PYFUZZYLITE, "--name", "mine")):
        assert hfc(*command).exit_code == 0
        refused_command(*command)
        assert hfc(*command, "--force").exit_code == 0


def test_cells_that_a_spreadsheet_would_compute():
    rows = [
        ["=1+1", "+cmd|' /C calc'!A0", "-x", "@SUM(A1)", "\tx", "\rx", "a=b", "", "-"],
        ["-1.5", "+2", "-1e-3", "-.5", -1.5, -2, None, float("-inf"), "–"],
    ]
    found = list(csv.reader(io.StringIO(writing.csv_text(rows), newline="")))
    quoted = ["'=1+1", "'+cmd|' /C calc'!A0", "'-x", "'@SUM(A1)", "'\tx", "'\nx", "a=b", "", "'-"]
    assert found[0] == quoted
    assert found[1] == ["-1.5", "+2", "-1e-3", "-.5", "-1.5", "-2", "", "-inf", "–"]


def test_a_name_that_no_file_can_have_is_a_line_everywhere(tmp_path):
    long = tmp_path / ("x" * 300)
    for code, *arguments in (
        (1, "export", PD, "--to", "json", "--out", long),
        (1, "batch", "--status", long),
        (2, "report", long),
        (2, "import", Path(f"{long}.fll")),
    ):
        assert refused_command(*arguments, code=code).count("\n") == 1


def searched(done):
    """A search after so many generations."""
    four = np.linspace(0.0, 1.0, done)
    history = dict.fromkeys(("best", "median", "diverged", "structures"), four)
    return SimpleNamespace(generation=done, history=SimpleNamespace(**history))


def test_no_line_says_that_nothing_is_left_when_much_is(monkeypatch, capsys):
    """Right after the compilation a generation seems to take no time."""
    now = [0.0]
    monkeypatch.setattr("hfc_design.cli.search_progress.time.monotonic", lambda: now[0])
    watch = Watch(load_scenario("c-axis-ramp", {"search.generations": 100}))
    for done, moment in ((1, 30.0), (2, 30.001), (3, 40.0), (4, 50.0), (5, 50.5), (50, 60.0)):
        now[0] = moment
        watch.generation(searched(done))
    lines = capsys.readouterr().err.splitlines()
    left = [re.search(r"(\d+) s left", line) for line in lines]
    assert [found and int(found[1]) for found in left] == [None, 485, 640, 31]


#: In one process, the lightest first: after each nothing heavy has been imported.
CODE = """
import os, sys
from hfc_design.cli import main
HEAVY = {"jax", "matplotlib"}
for heavy, *words in (
    [{*HEAVY, "numpy"}, "--help"],
    [HEAVY, "show", "plant", "c-axis"],
    [HEAVY, "show", "scenario", "c-axis-practical"],
    [HEAVY, "show", "design", "pd-only"],
    [HEAVY, "init", "--out", "mine.toml"],
    [HEAVY, "stability", "--json"],
    [HEAVY],
    [{"matplotlib"}, "list", "plants"],
):
    if not words:  # a shell asks for names
        os.environ |= {"_HFC_COMPLETE": "bash_complete", "COMP_WORDS": "hfc design c-axis-s"}
        os.environ["COMP_CWORD"] = "2"
    try:
        main(words, prog_name="hfc")
    except SystemExit:
        pass
    print("done")
    os.environ.pop("_HFC_COMPLETE", None)
    assert not heavy & {name.partition(".")[0] for name in sys.modules}, words
"""


def test_nothing_heavy_is_imported(tmp_path):
    told = [sys.executable, "-c", CODE]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        told, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment
    )
    assert done.returncode == 0, done.stderr
    names = done.stdout.split("done\n")[6].splitlines()
    assert names == ["file,c-axis-s", "plain,c-axis-sine", "plain,c-axis-step"]
