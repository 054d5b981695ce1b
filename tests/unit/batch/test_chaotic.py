"""Runs whose designs are chaotic: told as ranges, compared by their lower ends."""

import json

import pytest
from run_folders import batch_folder, hfc, table

TWO = [
    ({"scenario": "a", "search.preset": "race"}, [430.0, 440.0]),
    ({"scenario": "a", "search.preset": "cma"}, [400.0, 401.0]),
]


def made_chaotic(folder, lowest, highest):
    file = folder / "design.json"
    design = json.loads(file.read_text())
    ends = {"lowest": lowest, "median": None, "highest": highest, "count": 64}
    design["score"] |= {"chaotic": True, "repeats": {"fitness": ends}}
    file.write_text(json.dumps(design))


def test_it_counts_with_the_lower_end_and_is_told_as_a_range(tmp_path):
    first, second, *_ = batch_folder(tmp_path, TWO)
    made_chaotic(tmp_path / first, 362.04, 511.0)
    made_chaotic(tmp_path / second, 398.0, 441.0)
    assert hfc("report", tmp_path).exit_code == 0
    groups = table(tmp_path / "groups.csv")
    assert [row["search.preset"] for row in groups] == ["cma", "race"]
    assert [float(row["fitness_median"]) for row in groups] == [400.5, pytest.approx(380.02)]
    runs = {row["run"]: row for row in table(tmp_path / "runs.csv")}
    assert [runs[name]["fitness"] for name in (first, second)] == ["362.04", "398.0"]
    assert [row["fitness_highest"] for row in runs.values()] == ["511.0", "441.0", "", ""]
    page = (tmp_path / "report.html").read_text()
    assert "<td>362 to 511 (chaotic)</td>" in page
    assert "<td>430.0</td>" not in page
    assert "A chaotic design (2) has a range of 64 repeats" in " ".join(page.split())


@pytest.mark.parametrize("repeats", ["x", {"fitness": 1.0}, {"fitness": {"lowest": "x"}}])
def test_a_repeat_that_diverged_or_an_edited_range_stops_nothing(repeats, tmp_path):
    name, *_ = batch_folder(tmp_path, TWO)
    made_chaotic(tmp_path / name, None, 511.0)
    assert hfc("report", tmp_path).exit_code == 0
    assert "<td>diverged to 511 (chaotic)</td>" in (tmp_path / "report.html").read_text()
    file = tmp_path / name / "design.json"
    design = json.loads(file.read_text())
    design["score"]["repeats"] = repeats
    file.write_text(json.dumps(design))
    assert hfc("report", tmp_path).exit_code == 0
