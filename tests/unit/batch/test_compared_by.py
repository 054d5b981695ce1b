"""What runs of many are compared by: the merit where all were judged alike, else the fitness."""

import numpy as np
import pytest
from run_folders import batch_folder, reported, table, with_score

from hfc_design.batch.comparisons import compared
from hfc_design.batch.groups import grouped
from hfc_design.batch.results import runs_below

HARD = "fitness, LL eq. 5 / (1 + 300 stick share)"


def judge(out, names, merits, title=HARD):
    """Let finished runs be judged: the fitness stays, None is a design that diverged."""
    for name, merit in zip(names, merits, strict=True):
        lost = {"fitness": None} if merit is None else {}
        with_score(out / name, merit=merit, judged_by=title, **lost)


def page(out):
    return reported(out)[1]


def test_runs_judged_alike_are_compared_by_their_merit(tmp_path):
    """The fitness says the reverse."""
    groups = [
        ({"search.preset": "a"}, [10.0, 11.0, 12.0]),
        ({"search.preset": "b"}, [1.0, 2.0, 3.0]),
    ]
    names = batch_folder(tmp_path, groups)
    judge(tmp_path, names, [4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    first, second = grouped(runs_below(tmp_path))
    assert (first.settings, first.quartiles) == ({"search.preset": "b"}, (7.5, 8.0, 8.5))
    assert (first.measure, second.scores.tolist()) == (HARD, [4.0, 5.0, 6.0])
    assert compared([first, second])[0].a12 == 1.0
    assert f"Median, quartiles and best of {HARD} over runs" in page(tmp_path)
    rows = table(tmp_path / "runs.csv")
    assert {row["judged_by"] for row in rows} == {HARD}
    assert [row["merit"] for row in rows[:2]] == ["4.0", "5.0"]
    (row,) = table(tmp_path / "comparisons.csv")
    assert (row["measure"], row["group"]) == (HARD, "1")
    assert table(tmp_path / "groups.csv")[0]["merit_median"] == "8.0"


@pytest.mark.parametrize("title", ["fitness, LL eq. 5", None])
def test_runs_judged_in_two_ways_are_compared_by_their_fitness(title, tmp_path):
    """None is a run of an earlier version."""
    groups = [({"search.preset": "a"}, [10.0, 11.0]), ({"search.preset": "b"}, [1.0, 2.0])]
    names = batch_folder(tmp_path, groups)
    judge(tmp_path, names[:2], [4.0, 5.0])
    if title:
        judge(tmp_path, names[2:], [7.0, 8.0], title)
    first, second = grouped(runs_below(tmp_path))
    assert (first.measure, first.median, second.median) == ("fitness", 10.5, 1.5)
    assert "Median, quartiles and best of fitness over runs" in page(tmp_path)


def test_what_diverged_is_last_in_its_group_and_no_number_in_a_file(tmp_path):
    groups = [({"search.preset": "a"}, [1.0] * 4), ({"search.preset": "b"}, [1.0] * 4)]
    names = batch_folder(tmp_path, groups)
    judge(tmp_path, names, [None, None, None, -5.0, -7.0, -8.0, None, -9.0])
    first, second = grouped(runs_below(tmp_path))
    assert first.settings == {"search.preset": "b"}
    assert np.sort(first.scores).tolist() == [-np.inf, -9.0, -8.0, -7.0]
    assert first.median == -8.5
    assert second.median == -np.inf
    assert compared([first, second])[0].a12 == (9 + 3 * 0.5) / 16  # -5 beats all; 3 ties
    text = page(tmp_path)
    assert "diverged" in text
    assert "inf" not in (tmp_path / "groups.csv").read_text()
    assert "inf" not in (tmp_path / "runs.csv").read_text()


def test_histories_below_zero_and_with_generations_in_which_all_failed(tmp_path):
    names = batch_folder(tmp_path, [({}, [1.0, 2.0])])
    for name, best in zip(names, (["nan", "-3.5", "-0.25"], ["nan", "nan", "nan"]), strict=True):
        rows = [f"{k},{value},nan,16,1" for k, value in enumerate(best)]
        head = "generation,best,median,diverged,structures"
        (tmp_path / name / "history.csv").write_text("\n".join([head, *rows]) + "\n")
    runs = runs_below(tmp_path)
    assert [run.reason for run in runs] == ["", ""]
    assert runs[0].best[1:].tolist() == [-3.5, -0.25]
    assert "Best merit so far" in page(tmp_path)
