"""A search in which everything diverged gives no design, and a design that diverged no export."""

import pytest
from batches import batch, written

#: Gains so large that no individual stays finite, in float64 either, of those that are drawn.
ALL = """
simulation = { duration_s = 0.1, sample_time_s = 0.005 }
[search]
population = 12
generations = 2
[controller]
kind = "pd"
ranges = { kp = [1e12, 1e13], kd = [1e12, 1e13] }
"""


@pytest.fixture
def scenario(tmp_path):
    return written(tmp_path, ALL)


def test_a_cell_of_a_batch_has_failed_and_is_told_again(scenario, tmp_path):
    file = written(tmp_path, f"[set]\nscenario = '{scenario}'\n", "batch.toml")
    for _ in range(2):
        done = batch(file, "--out", tmp_path / "out")
        assert done.exit_code == 1
        assert "0 finished, 1 failed" in done.stdout
        assert "RunError: no design: every individual diverged" in done.stderr
        assert (tmp_path / "out" / "report.html").exists()
    assert "every individual diverged" in batch("--status", tmp_path / "out").stdout
