"""What a batch says in the end, and what the captions of its tables say in a paper."""

import scipy.stats
from run_folders import batch_folder, reported, table, with_score


def of_two(out, first, second):
    """What the terminal says of two groups."""
    batch_folder(out, [({"search.preset": "a"}, first), ({"search.preset": "b"}, second)])
    return reported(out)[0]


def test_nothing_is_said_to_be_better_with_too_few_seeds(tmp_path):
    """However large the difference is: p is 0.1 at least."""
    scores = [7.0, 8.0, 9.0], [1.0, 2.0, 3.0]
    assert scipy.stats.mannwhitneyu(*scores, method="exact").pvalue > 0.05
    told = of_two(tmp_path, *scores)
    assert "too few to show which group is better" in told
    assert "at least 4 runs in each group" in told
    assert "highest median" not in told
    scores = [7.0, 8.0, 9.0, 10.0], [1.0, 2.0, 3.0, 4.0]
    assert scipy.stats.mannwhitneyu(*scores, method="exact").pvalue < 0.05
    told = of_two(tmp_path / "more", *scores)
    assert "(4 runs). The other group is significantly lower." in told
    scores = [7.0, 8.0, 9.0, 10.0, 11.0], [1.0, 2.0, 3.0]  # of another size
    assert scipy.stats.mannwhitneyu(*scores, method="exact").pvalue < 0.05
    assert "significantly lower" in of_two(tmp_path / "uneven", *scores)


def test_groups_on_different_machines_are_told_so(tmp_path):
    """A lighter machine is followed better by whatever controller."""
    key = "plant.parameters.spindle_inertia"
    light, heavy = [7.0, 8.0, 9.0, 10.0], [1.0, 2.0, 3.0, 4.0]
    batch_folder(tmp_path, [({key: "3"}, light), ({key: "9"}, heavy)])
    told, _ = reported(tmp_path)
    assert f"The groups also differ in {key}: a higher score may come from an easier task." in told
    assert "The groups also differ in" not in of_two(tmp_path / "presets", light, heavy)


def test_runs_that_break_constraints_are_counted(tmp_path):
    """Of the first group three of four; page and terminal say it, of a sound batch nothing."""
    groups = [({"search.preset": "a"}, [7.0, 8.0, 9.0, 10.0]), ({"search.preset": "b"}, [1.0])]
    names = batch_folder(tmp_path / "broken", groups)
    for name in names[1:4]:
        with_score(tmp_path / "broken" / name, least_violated=True)
    told = "3 of 4 runs of group 1 violate constraints: no design tried there"
    said, page = reported(tmp_path / "broken")
    assert told in said
    assert "of group 2 break" not in said
    assert told in page
    assert "least_violated" not in page  # which is no metric
    assert {row["least_violated"] for row in table(tmp_path / "broken" / "runs.csv")} == {"", "1.0"}
    batch_folder(tmp_path / "sound", groups)
    assert "constraints" not in reported(tmp_path / "sound")[0]
