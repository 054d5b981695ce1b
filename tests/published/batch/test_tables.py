"""The tables of many runs, against numpy and SciPy, as CSV and as Parquet."""

import subprocess
import sys

import numpy as np
import pytest
import scipy.stats
from run_folders import PRESETS, batch_folder, hfc, table


def test_same_runs_same_bytes(tmp_path):
    """In another process, which has another order of what has none."""
    batch_folder(tmp_path, PRESETS)
    assert hfc("report", tmp_path).exit_code == 0
    names = ("report.html", "runs.csv", "groups.csv", "comparisons.csv")
    before = {name: (tmp_path / name).read_bytes() for name in names}
    command = [sys.executable, "-m", "hfc_design", "report", tmp_path]
    assert subprocess.run(command, stdout=subprocess.DEVNULL, check=True).returncode == 0
    assert before == {name: (tmp_path / name).read_bytes() for name in names}


def test_the_tables_against_numpy_and_scipy(large):
    fitness = {}
    for run in table(large / "runs.csv"):
        fitness.setdefault(run["group"], []).append(float(run["fitness"]))
    for group in table(large / "groups.csv"):
        own = [float(group[f"fitness_{part}"]) for part in ("lower_quartile", "median")]
        assert own == pytest.approx(np.percentile(fitness[group["group"]], [25, 50]))
    for row in table(large / "comparisons.csv"):
        x, y = fitness[row["group"]], fitness[row["other_group"]]
        found = scipy.stats.mannwhitneyu(x, y)
        assert float(row["p"]) == pytest.approx(found.pvalue, rel=1e-12)
        assert float(row["a12"]) == found.statistic / 2500
