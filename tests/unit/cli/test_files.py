"""Files that a user names: nothing is lost, nothing is left half, no cell is a formula."""

import csv
import io
import os
from pathlib import Path

from click.testing import CliRunner
from imported_files import PYFUZZYLITE

from hfc_design.cli import main
from hfc_design.formats import writing

PD = "pd-only"


def hfc(*arguments):
    return CliRunner().invoke(main, [str(item) for item in arguments])


def test_a_folder_that_is_not_there_is_found_before_anything_is_computed(tmp_path):
    file = tmp_path / "nowhere" / "mine.json"
    for arguments in (("simulate", "jee-koren-2004-aflc", "--learned"), ("train", PD, "--out")):
        done = hfc(*arguments, file)
        told = f"hfc: {arguments[-1]} {file}: there is no folder {file.parent}\n"
        assert (done.exit_code, done.stderr) == (2, told)
    assert hfc("export", PD, "--to", "c", "--out", tmp_path / "new" / "folder").exit_code == 0


def test_a_pipe_or_a_device_is_never_replaced_by_a_file(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    done = hfc("simulate", PD, "--csv", pipe, "--force")
    told = f"hfc: --csv {pipe}: is neither a file nor a folder; name another path\n"
    assert (done.exit_code, done.stderr) == (2, told)
    assert pipe.is_fifo()


def test_a_picture_of_another_kind_is_refused_before_anything_is_simulated(tmp_path, monkeypatch):
    monkeypatch.setattr("hfc_design.simulation.evaluating.evaluate", None)
    done = hfc("simulate", PD, "--plot", tmp_path / "mine.bmp")
    told = f"hfc: {tmp_path / 'mine.bmp'}: a plot has to end in .png, .svg or .pdf\n"
    assert (done.exit_code, done.stderr) == (2, told)


def test_two_options_cannot_name_one_file(tmp_path):
    file = tmp_path / "mine.png"
    done = hfc("simulate", PD, "--csv", file, "--plot", tmp_path / "." / "mine.png")
    assert (done.exit_code, done.stderr) == (2, f"hfc: --plot {file}: --csv names it too\n")
    assert not file.exists()


def test_the_names_that_commands_choose_are_not_overwritten_either(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for command in (("export", PD, "--to", "json"), ("import", PYFUZZYLITE, "--name", "mine")):
        assert hfc(*command).exit_code == 0
        assert "exists already" in hfc(*command).stderr
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
    for arguments in (
        ("export", PD, "--to", "json", "--out", long),
        ("batch", "--status", long),
        ("report", long),
        ("import", Path(f"{long}.fll")),
    ):
        done = hfc(*arguments)
        assert done.exit_code in (1, 2)
        assert done.stderr.startswith("hfc: ")
        assert done.stderr.count("\n") == 1
