"""Scores and metrics of 0, and those that no file can hold: the report is written all the same."""

import json

from run_folders import batch_folder, hfc, table


def test_a_ratio_over_zero_is_none(tmp_path):
    own, other = ({"scenario": "a", "search.preset": x} for x in ("race", "third"))
    names = batch_folder(tmp_path / "out", [(own, [0.0, 0.0]), (other, [0.0, 0.0])])
    sides = [{"of": own, "over": other}, {"of": own}]
    figures = [{"quantity": "q", "value": 0.0, "metric": "fitness", **side} for side in sides]
    plan = json.loads((tmp_path / "out" / "batch.json").read_text())
    plan["files"] = {"mine": {"published": figures}}
    (tmp_path / "out" / "batch.json").write_text(json.dumps(plan))
    done = hfc("report", tmp_path / "out")
    assert done.exit_code == 0, done.output
    rows = table(tmp_path / "out" / "published.csv")
    assert [row["simulated"] for row in rows] == ["", "0.0"]
    assert [row["ratio"] for row in rows] == ["", ""]
    assert len(table(tmp_path / "out" / "runs.csv")) == len(names)
