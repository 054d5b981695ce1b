"""Reports of runs that are damaged or have not finished, and folders without any."""

import shutil

import pytest
from run_folders import HOSTILE, batch_folder, reported, run_folder, table
from wording import refused_command

DAMAGED = {
    "no JSON": ("design.json", "{", "design.json: "),
    "no score": ("design.json", "{}", "has no score"),
    "a list": ("design.json", "[]", "has no score"),
    "nan": ("design.json", '{"score": {"fitness": NaN}}', "NaN is not a number"),
    "a word": ("design.json", '{"score": {"fitness": "high"}}', "must have a number as fitness"),
    "not UTF-8": ("design.json", b"\xff", "design.json: "),
    "empty": ("history.csv", "", "history.csv: must have a column best"),
    "head": ("history.csv", "generation,best\n", "at least one generation"),
    "cut": ("history.csv", "generation,best,median\n0,1.0,1.0\n1,1.", "row 3 is damaged"),
    "lost": ("history.csv", "generation,best\n0,1.0\n2,1.0\n", "row 3 is damaged"),
    "a folder": ("history.csv", None, "history.csv: cannot be read: Is a directory"),
    "words": ("history.csv", "generation,best\n0,one\n", "could not convert"),
    "infinite": ("history.csv", "generation,best\n0,inf\n", "not a number"),
}


def test_what_is_damaged_is_listed_and_stops_nothing(tmp_path):
    names = batch_folder(tmp_path, [({}, [1.0] * (2 + len(DAMAGED)))])
    for name, (file, content, _) in zip(names[1:], DAMAGED.values(), strict=False):
        path = tmp_path / name / file
        path.unlink()
        if content is None:
            path.mkdir()
        else:
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
    _, page = reported(tmp_path)
    first, *runs, last = table(tmp_path / "runs.csv")
    assert (first["reason"], last["reason"]) == ("", "")
    unread = [file == "design.json" for file, *_ in DAMAGED.values()]
    for run, (_, _, words), lost in zip(runs, DAMAGED.values(), unread, strict=True):
        assert words in run["reason"]
        assert words in page
        assert run["state"] == ("unreadable" if lost else "finished")
    (group,) = table(tmp_path / "groups.csv")
    assert int(group["runs"]) == len(names)
    assert int(group["finished"]) == len(names) - sum(unread)


def test_a_damaged_configuration_belongs_to_no_group(tmp_path):
    for name, text in (("one", 'name = "mine"\n[run]\nseed = 3\n'), ("two", "name = ")):
        run_folder(tmp_path / name, 1.0)
        (tmp_path / name / "config.toml").write_text(text)
    (tmp_path / "loop").symlink_to(tmp_path)
    run_folder(tmp_path / "three", 1.0)
    reported(tmp_path)
    found = [(r["run"], r["group"], r["state"], r["reason"]) for r in table(tmp_path / "runs.csv")]
    assert found[0] == ("one", "1", "finished", "")
    missing = "config.toml: cannot be read: No such file or directory"
    assert found[1] == ("three", "", "unreadable", missing)
    assert found[2][:3] == ("two", "", "unreadable")
    assert found[2][3].startswith("config.toml: is not valid TOML: Invalid value")
    assert len(found) == 3


def test_what_has_not_finished_is_listed_with_its_reason(tmp_path):
    names = batch_folder(tmp_path, [({}, [1.0] * 5)])
    for name in names[1:]:
        (tmp_path / name / "design.json").unlink()
    (tmp_path / ".batch").mkdir()
    (tmp_path / ".batch" / f"{names[1]}.failed").write_text(f"RunError: {HOSTILE}\n")
    (tmp_path / names[2] / "config.toml").touch()
    shutil.rmtree(tmp_path / names[4])
    run_folder(tmp_path / "elsewhere", 1.0)  # not in the plan
    _, page = reported(tmp_path)
    found = [(run["state"], run["reason"]) for run in table(tmp_path / "runs.csv")]
    assert found == [
        ("finished", ""),
        ("failed", f"RunError: {HOSTILE}".replace("\x01", "?")),
        ("broken off", "after 3 generations"),
        ("waiting", ""),
        ("waiting", ""),
    ]
    assert "5 runs: 1 finished, 1 failed, 1 broken off, 2 waiting." in page


def test_nothing_has_finished(tmp_path):
    batch_folder(tmp_path, [({}, [1.0])])
    shutil.rmtree(tmp_path / ("0" * 16))
    assert "No run has finished." in reported(tmp_path)[1]


@pytest.mark.parametrize(
    ("files", "where"),
    [
        ({}, ""),
        ({"notes.txt": "hello"}, ""),
        ({"batch.json": "{"}, "/batch.json"),
        ({"batch.json": "[1]"}, "/batch.json"),
        ({"config.toml": ""}, ""),
        ({"design.json": "{}"}, ""),
    ],
)
def test_folders_that_cannot_be_reported(files, where, tmp_path):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    found = refused_command("report", tmp_path)
    assert found.where == f"{tmp_path}{where}"
    assert found.count("\n") == 1
    assert not (tmp_path / "report.html").exists()
    assert refused_command("report", tmp_path / "none").where == str(tmp_path / "none")
