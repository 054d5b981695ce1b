"""Files that a user names: nothing is lost, nothing is left half, no cell is a formula."""

import csv
import errno
import io
import os
from pathlib import Path

import pytest
from click.testing import CliRunner
from imported_files import PYFUZZYLITE

from hfc_design.cli import main
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS, writing

PD = "pd-only"


def hfc(*arguments):
    return CliRunner().invoke(main, [str(item) for item in arguments])


@pytest.mark.parametrize(
    ("arguments", "option", "suffix"),
    [
        (("simulate", PD), "--csv", ".csv"),
        (("simulate", PD), "--plot", ".png"),
        (("score", PD, "--spread", "0.1", "--samples", "2"), "--plot", ".svg"),
        (("stability",), "--plot", ".pdf"),
        (("export", PD, "--to", "json"), "--out", ".json"),
        (("import", PYFUZZYLITE, "--name", "mine"), "--out", ".json"),
    ],
)
def test_a_file_is_overwritten_with_force_alone(arguments, option, suffix, tmp_path):
    file = tmp_path / f"mine{suffix}"
    file.write_text("old")
    done = hfc(*arguments, option, file)
    told = f"hfc: {option} {file}: exists already; name another path, or add --force\n"
    assert (done.exit_code, done.stderr) == (2, told)
    assert file.read_text() == "old"
    assert hfc(*arguments, option, file, "--force").exit_code == 0
    assert len(file.read_bytes()) > 100
    assert [*tmp_path.iterdir()] == [file]


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


def test_an_export_into_a_folder_leaves_what_else_is_in_it(tmp_path):
    design, out = "jee-koren-2004-flc", tmp_path / "out"
    assert hfc("export", design, "--to", "csv", "--out", out).exit_code == 0
    whole = {file.name: file.read_bytes() for file in out.iterdir()}
    (out / "mine.txt").write_text("mine")
    (out / "rules.csv").write_text("changed")
    assert hfc("export", design, "--to", "csv", "--out", out).exit_code == 2
    assert hfc("export", design, "--to", "csv", "--out", out, "--force").exit_code == 0
    found = {file.name: file.read_bytes() for file in out.iterdir()}
    assert found == whole | {"mine.txt": b"mine"}
    assert [*tmp_path.iterdir()] == [out]


@pytest.mark.parametrize("there", [False, True])
@pytest.mark.parametrize("fails_at", range(6))
def test_a_disk_that_is_full_leaves_no_part_of_an_export(fails_at, there, tmp_path, monkeypatch):
    left = iter(range(fails_at))

    def full(path, content):
        if next(left, None) is None:
            raise RunError(f"{path}: cannot be written: {os.strerror(errno.ENOSPC)}")
        write_whole(path, content)

    monkeypatch.setattr(writing, "write_whole", full)
    out = tmp_path / "a" / "b"
    if there:
        out.mkdir(parents=True)
        (out / "rules.csv").write_text("old")
    design = load_design("jee-koren-2004-flc")
    count = len(FORMATS["csv"].content(design))
    assert 3 <= count < 6
    if fails_at >= count:
        FORMATS["csv"].write(design, out)
        assert len([*out.iterdir()]) == count
        return
    with pytest.raises(RunError, match="No space left"):
        FORMATS["csv"].write(design, out)
    found = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert [path.read_text() for path in found] == ["old"] * there
    assert there or not out.parent.exists()


def test_cells_that_a_spreadsheet_would_compute():
    rows = [
        ["=1+1", "+cmd|' /C calc'!A0", "-x", "@SUM(A1)", "\tx", "\rx", "a=b", "", "-"],
        ["-1.5", "+2", "-1e-3", "-.5", -1.5, -2, None, float("-inf"), "–"],
    ]
    found = list(csv.reader(io.StringIO(writing.csv_text(rows), newline="")))
    quoted = ["'=1+1", "'+cmd|' /C calc'!A0", "'-x", "'@SUM(A1)", "'\tx", "'\nx", "a=b", "", "'-"]
    assert found[0] == quoted
    assert found[1] == ["-1.5", "+2", "-1e-3", "-.5", "-1.5", "-2", "", "-inf", "–"]


def test_labels_of_a_batch_are_no_formulas(tmp_path):
    file = tmp_path / "mine.toml"
    cell = '[[cells]]\nlabel = "=HYPERLINK(1)"\ndesign = "pd-only"\nsimulation.duration_s = 0.05\n'
    file.write_text(cell)
    done = hfc("batch", file, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    with (tmp_path / "out" / "runs.csv").open(newline="") as table:
        (row,) = csv.DictReader(table)
    assert row["label"] == "'=HYPERLINK(1)"
    assert float(row["fitness"]) == float(row["fitness"].strip())
    assert float(row["final_error_rad"]) != 0.0


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
