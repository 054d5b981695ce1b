"""The tables of many runs, against numpy and SciPy, as CSV and as Parquet."""

import subprocess
import sys

from run_folders import PRESETS, batch_folder, hfc


def test_same_runs_same_bytes(tmp_path):
    """In another process, which has another order of what has none."""
    batch_folder(tmp_path, PRESETS)
    assert hfc("report", tmp_path).exit_code == 0
    names = ("report.html", "runs.csv", "groups.csv", "comparisons.csv")
    before = {name: (tmp_path / name).read_bytes() for name in names}
    command = [sys.executable, "-m", "hfc_design", "report", tmp_path]
    assert subprocess.run(command, stdout=subprocess.DEVNULL, check=True).returncode == 0
    assert before == {name: (tmp_path / name).read_bytes() for name in names}
