"""Files that a user names: nothing is lost, nothing is left half, no cell is a formula."""

import errno
import os

import pytest
from imported_files import PYFUZZYLITE
from run_folders import hfc
from wording import refused_command

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError
from hfc_design.files.loop_setup import load_design
from hfc_design.formats import FORMATS, writing

PD = "pd-only"
SHORT = ("--set", "simulation.duration_s=0.1")


@pytest.mark.parametrize(
    ("arguments", "option", "suffix"),
    [
        (("simulate", PD, *SHORT), "--csv", ".csv"),
        (("simulate", PD, *SHORT), "--plot", ".png"),
        (("score", PD, "--spread", "0.1", "--samples", "4", *SHORT), "--plot", ".svg"),
        (("stability",), "--plot", ".pdf"),
        (("init",), "--out", ".toml"),
        (("export", PD, "--to", "json"), "--out", ".json"),
        (("import", PYFUZZYLITE, "--name", "mine"), "--out", ".json"),
    ],
)
def test_a_file_is_overwritten_with_force_alone(arguments, option, suffix, tmp_path):
    file = tmp_path / f"mine{suffix}"
    file.write_text("old")
    assert refused_command(*arguments, option, file).where == f"{option} {file}"
    assert file.read_text() == "old"
    assert hfc(*arguments, option, file, "--force").exit_code == 0
    assert len(file.read_bytes()) > 100
    assert [*tmp_path.iterdir()] == [file]


def test_an_export_into_a_folder_leaves_what_else_is_in_it(tmp_path):
    design, out = "jee-koren-2004-flc", tmp_path / "out"
    assert hfc("export", design, "--to", "csv", "--out", out).exit_code == 0
    whole = {file.name: file.read_bytes() for file in out.iterdir()}
    (out / "mine.txt").write_text("mine")
    (out / "rules.csv").write_text("changed")
    refused_command("export", design, "--to", "csv", "--out", out)
    assert hfc("export", design, "--to", "csv", "--out", out, "--force").exit_code == 0
    found = {file.name: file.read_bytes() for file in out.iterdir()}
    assert found == whole | {"mine.txt": b"mine"}
    assert [*tmp_path.iterdir()] == [out]


@pytest.mark.parametrize("there", [False, True])
@pytest.mark.parametrize("fails_at", [0, 2, 5])
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
