"""Files that a user names: nothing is lost, nothing is left half, no cell is a formula."""

import csv
import io
import os
from pathlib import Path

from imported_files import PYFUZZYLITE
from run_folders import hfc
from wording import refused_command

from hfc_design.formats import writing

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
