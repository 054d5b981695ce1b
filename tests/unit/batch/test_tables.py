"""The tables of many runs as CSV, as Parquet and in a paper."""

import sys

import pytest
import tex
from run_folders import PRESETS, batch_folder, hfc, table, with_score
from wording import refused_command


def test_parquet_holds_what_the_csv_holds(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    batch_folder(tmp_path, PRESETS)
    assert hfc("report", tmp_path, "--parquet").exit_code == 0
    stored = parquet.read_table(tmp_path / "runs.parquet").to_pydict()
    rows = table(tmp_path / "runs.csv")
    assert list(stored) == list(rows[0])
    for key, values in stored.items():
        assert [("" if v is None else str(v)) for v in values] == [row[key] for row in rows]
    assert stored["fitness"][0] == 10.0
    assert stored["run.seed"][:2] == [0, 1]


def test_parquet_without_pyarrow(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    batch_folder(tmp_path, PRESETS)
    refused_command("report", tmp_path, "--parquet")
    assert not (tmp_path / "runs.csv").exists()


def test_the_best_of_each_task_is_bold_in_a_paper(tmp_path):
    """Less is better of an error, more of a fitness; tasks do not compare."""
    runs = [("a", "x", 5.0, 2e-3), ("a", "y", 4.0, 1e-3)]
    runs += [("b", "x", 9.0, 4e-3), ("b", "y", 8.0, 5e-3)]
    told = [({"scenario": task, "search.preset": own}, [score]) for task, own, score, _ in runs]
    for name, (*_, error) in zip(batch_folder(tmp_path, told), runs, strict=True):
        with_score(tmp_path / name, rms_error_rad=error, merit=error)
        (tmp_path / name / "config.toml").write_text('name = "a"\n')
    assert hfc("report", tmp_path, "--latex").exit_code == 0
    text = (tmp_path / "latex" / "metrics.tex").read_text()
    assert tex.rows(text)[0] == ["metric", "1", "2", "3", "4"]
    bold = {line.split(" & ")[0]: line for line in text.splitlines() if "textbf" in line}
    assert bold == {"rms error [mrad]": r"rms error [mrad] & 2 & \textbf{1} & \textbf{4} & 5 \\"}
    groups = (tmp_path / "latex" / "groups.tex").read_text()
    first = [line for line in groups.splitlines() if "textbf" in line]
    assert [line.split(" & ")[0] for line in first] == ["1", "3"]
    assert rf"\label{{tab:{tmp_path.name.lower().replace('_', '-')}-groups}}" in groups
