"""Runs whose designs are chaotic: told as ranges, compared by their lower ends."""

import pytest
from run_folders import batch_folder, reported, table, with_score

TWO = [
    ({"scenario": "a", "search.preset": "race"}, [430.0, 440.0]),
    ({"scenario": "a", "search.preset": "cma"}, [400.0, 401.0]),
]


def made_chaotic(folder, lowest, highest):
    ends = {"lowest": lowest, "median": None, "highest": highest, "count": 64}
    with_score(folder, chaotic=True, repeats={"fitness": ends})


def test_it_counts_with_the_lower_end_and_is_told_as_a_range(tmp_path):
    first, second, *_ = batch_folder(tmp_path, TWO)
    made_chaotic(tmp_path / first, 362.04, 511.0)
    made_chaotic(tmp_path / second, 398.0, 441.0)
    _, page = reported(tmp_path)
    groups = table(tmp_path / "groups.csv")
    assert [row["search.preset"] for row in groups] == ["cma", "race"]
    assert [float(row["fitness_median"]) for row in groups] == [400.5, pytest.approx(380.02)]
    runs = {row["run"]: row for row in table(tmp_path / "runs.csv")}
    assert [runs[name]["fitness"] for name in (first, second)] == ["362.04", "398.0"]
    assert [row["fitness_highest"] for row in runs.values()] == ["511.0", "441.0", "", ""]
    assert "<td>362 to 511 (chaotic)</td>" in page
    assert "<td>430.0</td>" not in page
    assert "A chaotic design (2) has a range (in 64 repeats" in page
