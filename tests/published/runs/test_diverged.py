"""A search in which everything diverged gives no design, and a design that diverged no export."""

import csv
import re

import numpy as np
import pytest
from batches import batch, written
from run_folders import hfc

from hfc_design import api
from hfc_design.core.records import RunError
from hfc_design.files.design import design_json, parse_design
from hfc_design.runs import champion, run

#: Gains so large that no individual stays finite, in float64 either, of those that are drawn.
ALL = """
simulation = { duration_s = 0.1, sample_time_s = 0.005 }
controller = { kind = "pd", ranges = { kp = [1e12, 1e13], kd = [1e12, 1e13] } }
[search]
population = 12
generations = 2
informed = 0.0
"""


@pytest.fixture
def scenario(tmp_path):
    return written(tmp_path, ALL)


def test_it_fails_with_what_to_try_and_can_be_resumed(scenario, tmp_path):
    out = tmp_path / "run"
    for arguments in ((scenario,), ("--resume",), ("--resume",)):
        done = hfc("design", *arguments, "--out", out, "--quiet")
        assert done.exit_code == 1
        why = r"\((current|spindle_velocity|the command) runs away at 0\.\d+ s\); try a larger"
        *warned, line = done.stderr.splitlines()  # of so few samples
        assert re.match("hfc: no design: every individual diverged " + why, line)
        assert len(line) < 300 + len(str(out))
        assert all(one.startswith("hfc: warning: simulation: 0.1 s in samples") for one in warned)
        assert {path.name for path in out.iterdir()} == {run.CONFIG, run.CHECKPOINT, run.HISTORY}
    with (out / run.HISTORY).open() as file:
        assert [row["diverged"] for row in csv.DictReader(file)] == ["12", "12"]
    for command in ("report", "score"):
        done = hfc(command, out)
        assert done.exit_code == 2
        assert "has no finished run (no design.json); continue with:" in done.stderr
        assert f"hfc design --resume --out {out}" in done.stderr


def test_a_champion_that_diverges_in_float64_alone_is_none(tmp_path, monkeypatch):
    def failed(design, scenario, evaluate=champion.evaluate):
        return evaluate(design, scenario)._replace(diverged=True, merit=-np.inf, fitness=-np.inf)

    monkeypatch.setattr(champion, "evaluate", failed)
    small = {"simulation.duration_s": 0.1, "search.population": 12, "search.generations": 2}
    small["controller"] = {"kind": "pd"}
    with pytest.raises(RunError, match=r"no design: the best \d+ diverge in float64; try"):
        api.design(api.load_scenario("c-axis-ramp", small), tmp_path / "run")
    assert not (tmp_path / "run" / "design.json").exists()


@pytest.mark.parametrize("target", ["json", "c", "st"])
def test_a_design_that_says_it_diverged_is_exported_only_anyway(target, tmp_path):
    design = api.load_design("lin-lee-1999-table-1")
    score = {"scenario": "fast", "fitness": None, "merit": None}
    bad = parse_design(design_json(design.model_copy(update={"score": score})), "bad")
    assert bad.failed
    assert not design.failed
    file, out = tmp_path / "bad.json", tmp_path / "out"
    file.write_text(design_json(bad))
    done = hfc("export", file, "--to", target, "--out", out)
    assert done.exit_code == 2
    assert "diverged on fast when it was scored; to export it" in done.stderr
    assert not out.exists()
    with pytest.raises(api.UserError, match="diverged on fast"):
        api.export(bad, target, out)
    assert not out.exists()
    assert hfc("export", file, "--to", target, "--out", out, "--anyway").exit_code == 0
    assert out.exists()
    api.export(bad, target, tmp_path / "again", anyway=True)


def test_a_cell_of_a_batch_has_failed_and_is_told_again(scenario, tmp_path):
    file = written(tmp_path, f"[set]\nscenario = '{scenario}'\n", "batch.toml")
    for _ in range(2):
        done = batch(file, "--out", tmp_path / "out")
        assert done.exit_code == 1
        assert "0 finished, 1 failed" in done.stdout
        assert "RunError: no design: every individual diverged" in done.stderr
        assert (tmp_path / "out" / "report.html").exists()
    assert "every individual diverged" in batch("--status", tmp_path / "out").stdout


def test_an_error_that_only_float32_cannot_hold_is_told(tmp_path):
    """Ends near 1e20 rad in float64."""
    lost = written(tmp_path, ALL.replace("1e12, 1e13", "1e9, 1.001e9"))
    done = hfc("design", lost, "--out", tmp_path / "run", "--quiet")
    assert "hfc: no design: every individual diverged (one does not in float64); try" in done.stderr
