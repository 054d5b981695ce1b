"""Many runs stand by whether their designs can be used, and the best usable one is picked."""

import json

import pytest
from run_folders import batch_folder, hfc, reported, table, with_answer, with_score
from wording import refused_command

import hfc_design.api
from hfc_design.files.design import BUILTIN

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
    assert "too few to show which group is better" in said
    assert "<td>on this model only</td><td>100</td><td>2</td><td>50</td>" in page
    for name in order:
        assert name in page


def test_an_answer_of_an_earlier_version_has_no_verdict(judged):
    for path in judged.glob("*/usable.json"):
        told = json.loads(path.read_text())
        del told["verdict"], told["margins"]
        path.write_text(json.dumps(told))
    assert hfc("report", judged).exit_code == 0
    rows = table(judged / "runs.csv")
    assert [row["verdict"] for row in rows] == ["yes", "yes", "no", "no"]
    assert "sensitivity" not in rows[0]
    (judged / ("0" * 16) / "usable.json").write_text("{}")
    assert "usable.json: has no answer" in reported(judged)[1]


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
