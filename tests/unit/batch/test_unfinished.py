"""Runs that are damaged, unfinished or of no use, and which of the others is picked."""

import json
import shutil

import pytest
from run_folders import (
    HOSTILE,
    batch_folder,
    hfc,
    reported,
    run_folder,
    table,
    with_answer,
    with_score,
)
from wording import refused_command

import hfc_design.api
from hfc_design.files.design import BUILTIN

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


#: Settings of a group, fitness of its seeds, their verdicts and shares.
RUNS = [
    ({"robust.spread": 0.1}, [9.0, 8.0], [("no", 0.98), ("on this model only", 1.0)]),
    ({"robust.spread": 0.2}, [1.0, 3.0], [("yes", 0.995), ("yes", 0.995)]),
]


@pytest.fixture
def judged(tmp_path):
    """A batch in which the highest merit has the worst answer."""
    names = batch_folder(tmp_path, [run[:2] for run in RUNS])
    answers = [answer for *_, each in RUNS for answer in each]
    scores = [score for _, each, _ in RUNS for score in each]
    for name, (verdict, share), score in zip(names, answers, scores, strict=True):
        worst = {"sensitivity": 2, "phase_margin_deg": 50.0, "gain_margin": None}
        told = {key: {"value": x, "at": "rest"} for key, x in worst.items()}
        with_answer(tmp_path / name, verdict, share, margins={"stable": True, "worst": told})
        with_score(tmp_path / name, merit=score, judged_by="merit", usable={"share": share})
    return tmp_path


def test_runs_and_groups_stand_by_verdict_share_and_merit(judged):
    said, page = reported(judged)
    rows = table(judged / "runs.csv")
    order = ["spread=0.2, seed=1", "spread=0.2, seed=0", "spread=0.1, seed=1", "spread=0.1, seed=0"]
    assert [row["called"] for row in rows] == order
    assert [row["verdict"] for row in rows] == ["yes", "yes", "on this model only", "no"]
    assert [row["share"] for row in rows] == ["0.995", "0.995", "1.0", "0.98"]
    assert "gain_margin" not in rows[0]  # which has no end
    assert {(row["sensitivity"], row["phase_margin_deg"]) for row in rows} == {("2.0", "50.0")}
    assert "usable" not in rows[0]
    assert [row["robust.spread"] for row in table(judged / "groups.csv")] == ["0.2", "0.1"]
    assert "Usable designs of group 1: spread 0.2: 2 of 2; median share of unseen" in said
    assert "at least 4 runs in each group" in said
    numbers = "".join(f'<td class="value">{x}</td>' for x in (100, 2, 50))
    assert f"<td>on this model only</td>{numbers}" in page
    for name in order:
        assert name in page


def test_the_best_usable_design_of_a_batch_is_picked(judged):
    assert "spread=0.2, seed=1" in hfc("pick", judged).stdout
    done = hfc("pick", judged, "--out", judged / "best.json")
    assert done.exit_code == 0, done.output
    own = judged / f"{3:016x}" / "design.json"
    assert (judged / "best.json").read_text() == own.read_text()
    score = json.loads(own.read_text())["score"]  # which nothing else of a design goes with yet
    whole = json.loads((BUILTIN / "pd-only.json").read_text())
    own.write_text(json.dumps(whole | {"score": score}))
    assert hfc_design.api.pick(judged).name == "pd-only"


def test_of_a_batch_without_a_usable_design_none_is_picked(judged):
    for path in judged.glob("*/usable.json"):
        with_answer(path.parent, "no", 0.5)
    lost = refused_command("pick", judged)
    assert "spread=0.1, seed=0" in lost  # which has the highest merit
    for path in judged.glob("*/usable.json"):
        path.unlink()
    refused_command("pick", judged, "--out", judged / "best.json")
    refused_command("pick", judged, "--knee")
    assert not (judged / "best.json").exists()
