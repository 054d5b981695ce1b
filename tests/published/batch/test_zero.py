"""Scores and metrics of 0, and those that no file can hold: the report is written all the same."""

import json

import pytest
from run_folders import hfc
from sledge import BUDGET


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_metric_that_overflows_is_null_and_keeps_its_report(own, known_use):
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
