"""Scores and metrics of 0, and those that no file can hold: the report is written all the same."""

import json

import pytest
from run_folders import batch_folder, hfc, table
from sledge import BUDGET

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.report import verdict
from hfc_design.simulation.evaluating import evaluate


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


def test_a_contour_error_of_zero_or_no_number_is_told():
    scenario = load_scenario("feed-drive-circle", {"simulation.duration_s": 0.2})
    name = "jee-koren-2004-flc"
    found = evaluate(load_design(name), scenario)
    key = next(iter(found.metrics))
    for value, told in ((0.0, "a contour error of 0 BLU"), (None, "a contour error of inf BLU")):
        own = found._replace(metrics=found.metrics | {key: value})
        text = verdict.summary(scenario, own, {name: found})
        assert told in text
        assert "times as large" not in text


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:overflow")
def test_a_metric_that_overflows_is_null_and_keeps_its_report(own):
    """The machine is linear, so that its error stays finite and the error's square does not."""
    step = "reference={kind='step',height=1e200}"
    use = ("--fitness", "mine:LAST", "--controller", "mine:P")
    small = ("--set", step, "--set", "run.precision=float64", *use, *BUDGET)
    done = hfc("design", "sledge.toml", "--plant", "mine:SLEDGE", *small, "--out", "run")
    assert done.exit_code == 0, done.output
    done = hfc("score", "run", "--json")
    found = json.loads(done.stdout, parse_constant=lambda text: 1 / 0)
    assert not found["diverged"]
    assert found["rms_error_m"] is None
    assert found["max_error_m"] == 1e200
