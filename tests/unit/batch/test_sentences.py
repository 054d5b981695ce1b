"""What a batch says in the end, and what the captions of its tables say in a paper."""

import re

import scipy.stats
import tex
from run_folders import PRESETS, batch_folder, hfc, reported, table, with_score


def of_two(out, first, second):
    """What the terminal says of two groups."""
    batch_folder(out, [({"search.preset": "a"}, first), ({"search.preset": "b"}, second)])
    return reported(out)[0]


def test_nothing_is_said_to_be_better_with_too_few_seeds(tmp_path):
    """However large the difference is: p is 0.1 at least."""
    scores = [7.0, 8.0, 9.0], [1.0, 2.0, 3.0]
    assert scipy.stats.mannwhitneyu(*scores, method="exact").pvalue > 0.05
    told = of_two(tmp_path, *scores)
    assert "cannot be shown with so few runs" in told
    assert "at least 4 runs in each group" in told
    assert "highest median" not in told
    scores = [7.0, 8.0, 9.0, 10.0], [1.0, 2.0, 3.0, 4.0]
    assert scipy.stats.mannwhitneyu(*scores, method="exact").pvalue < 0.05
    told = of_two(tmp_path / "more", *scores)
    assert "(4 runs). The other group is lower by more than chance." in told
    scores = [7.0, 8.0, 9.0, 10.0, 11.0], [1.0, 2.0, 3.0]  # of another size
    assert scipy.stats.mannwhitneyu(*scores, method="exact").pvalue < 0.05
    assert "lower by more than chance" in of_two(tmp_path / "uneven", *scores)


def test_groups_on_different_machines_are_told_so(tmp_path):
    """A lighter machine is followed better by whatever controller."""
    key = "plant.parameters.spindle_inertia"
    light, heavy = [7.0, 8.0, 9.0, 10.0], [1.0, 2.0, 3.0, 4.0]
    batch_folder(tmp_path, [({key: "3"}, light), ({key: "9"}, heavy)])
    told, _ = reported(tmp_path)
    assert f"They differ in {key} too: a higher score may be that of an easier task." in told
    assert "They differ in" not in of_two(tmp_path / "presets", light, heavy)


FITNESS = """
[fitness]
kind = "tolerances"
[fitness.tolerances]
settled_rms_error = "2 mrad"
chatter = {tolerance = 0.3, weight = 0.5}
"""


def test_captions_say_what_the_fitness_of_all_is(tmp_path):
    """With the units of the machine; nothing where tasks have different ones."""
    told = (
        "The fitness is 1 / weighted mean of settled_rms_error / 0.002 [rad] (weight 1), "
        "chatter / 0.3 [V] (weight 0.5); 1 is just tolerated"
    )
    names = batch_folder(tmp_path, PRESETS)
    for name in names:
        (tmp_path / name / "config.toml").write_text(FITNESS)
    assert hfc("report", tmp_path, "--latex").exit_code == 0
    for name in ("groups", "comparisons", "metrics"):
        text = (tmp_path / "latex" / f"{name}.tex").read_text()
        assert told in tex.printed(re.search(r"\\caption\{(.*)\}\n", text)[1])
    for name in names[-3:]:  # of the other task
        (tmp_path / name / "config.toml").write_text(FITNESS.replace("0.3", "0.2"))
    assert hfc("report", tmp_path, "--latex", "--force").exit_code == 0
    assert "The fitness is" not in (tmp_path / "latex" / "groups.tex").read_text()


def test_runs_that_break_constraints_are_counted(tmp_path):
    """Of the first group three of four; page and terminal say it, of a sound batch nothing."""
    groups = [({"search.preset": "a"}, [7.0, 8.0, 9.0, 10.0]), ({"search.preset": "b"}, [1.0])]
    names = batch_folder(tmp_path / "broken", groups)
    for name in names[1:4]:
        with_score(tmp_path / "broken" / name, least_violated=True)
    told = "3 of 4 runs of group 1 break constraints: no design that was tried there"
    said, page = reported(tmp_path / "broken")
    assert told in said
    assert "of group 2 break" not in said
    assert told in page
    assert "least_violated" not in page  # which is no metric
    assert {row["least_violated"] for row in table(tmp_path / "broken" / "runs.csv")} == {"", "1.0"}
    batch_folder(tmp_path / "sound", groups)
    assert "constraints" not in reported(tmp_path / "sound")[0]
