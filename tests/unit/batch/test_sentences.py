"""What a batch says in the end, and what the captions of its tables say in a paper."""

import json
import re

import scipy.stats
import tex
from run_folders import PRESETS, batch_folder, hfc, reported, table, with_score

from hfc_design.batch.comparisons import compared
from hfc_design.batch.groups import grouped
from hfc_design.batch.results import runs_below


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


def test_one_seed_each_shows_nothing(tmp_path):
    assert "which may be chance: run each group with several seeds" in of_two(
        tmp_path, [9.0], [1.0]
    )


def test_units_that_nobody_here_knows_are_missed_aloud(tmp_path):
    """The batch knows by which module it had its machine."""
    (name,) = batch_folder(tmp_path, [({}, [1.0])])
    (tmp_path / name / "config.toml").write_text('plant = {name = "of-somebody"}\n')
    path = tmp_path / name / "design.json"
    made = {"plugins": {"plant": {"of-somebody": "theirs:AXIS"}}}
    path.write_text(json.dumps(json.loads(path.read_text()) | {"provenance": made}))
    done = hfc("report", tmp_path, "--latex")
    assert done.exit_code == 0
    (line,) = done.stderr.splitlines()
    assert line.startswith("hfc: warning: the metrics of c-axis-ramp are shown without units")
    assert line.endswith(": give --use theirs:AXIS")


def test_captions_of_a_batch_stand_alone(tmp_path):
    """Measure, test, correction, and what the numbers of the groups mean."""
    batch_folder(tmp_path, PRESETS)
    assert hfc("report", tmp_path, "--latex").exit_code == 0
    told = {}
    for path in (tmp_path / "latex").iterdir():
        told[path.stem] = tex.printed(re.search(r"\\caption\{(.*)\}\n", path.read_text())[1])
    assert "best of fitness over runs that differ only in their seed" in told["groups"]
    for words in ("by fitness", "Mann-Whitney U", "Holm’s correction for all 3", "up to 0.05"):
        assert words in told["comparisons"].replace("'", "’")
    key = "Groups: 1: preset race in a; 2: preset third in a; 3: preset lin-lee-1999 in a; 4"
    assert key in told["comparisons"]
    assert key in told["metrics"]


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
        "chatter / 0.3 [V] (weight 0.5); 1 is just within tolerance"
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


def test_what_is_found_prints_itself_in_a_line(tmp_path):
    """A notebook shows a list of them."""
    batch_folder(tmp_path, PRESETS)
    groups = grouped(runs_below(tmp_path))
    first = compared(groups)[0]
    assert repr(groups[0]) == (
        "Group(label='1: preset race', task='a', measure='fitness', median=12, finished=5)"
    )
    p = scipy.stats.mannwhitneyu(PRESETS[0][1], PRESETS[2][1]).pvalue
    start = "Comparison(first='1: preset race', second='2: preset third', a12=1, "
    assert repr(first).startswith(f"{start}p={p:.4g}, holm=")


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
