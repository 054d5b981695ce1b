"""The page and the tables of many runs, and the page of one that was run without."""

import csv
import itertools
import json
import re
import shutil
import subprocess
import sys
from collections import Counter
from html.parser import HTMLParser

import numpy as np
import phone
import pytest
import scipy.stats
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.runs.batch.runs import runs_below
from hfc_design.runs.batch.summary import compared, grouped, holm, runs_needed, smallest_p

HOSTILE = '<script>alert("1")</script> & $x^$ \x01 Ω 漢'
TINY = """
[set]
search.population = 16
search.generations = 3
simulation.duration_s = 0.1
[grid]
search.preset = ["race", "lin-lee-1999"]
run.seed = [0, 1]
"""


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def table(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def run_folder(path, fitness, generations=3):
    """What a finished run leaves behind, as far as a summary reads it."""
    path.mkdir(parents=True)
    score = {"scenario": "s", "fitness": fitness, "rms_error_rad": 1e-3, "settling_time_s": None}
    (path / "design.json").write_text(json.dumps({"format": "x", "score": score}))
    rows = [f"{k},{fitness * (k + 1) / generations!r},1.0,0,5" for k in range(generations)]
    (path / "history.csv").write_text(
        "generation,best,median,diverged,structures\n" + "\n".join(rows) + "\n"
    )


def batch_folder(out, groups, **run):
    """A batch of finished runs: (settings of a group, fitness of each of its seeds)."""
    plan = {}
    for settings, fitness in groups:
        for seed, value in enumerate(fitness):
            name = f"{len(plan):016x}"
            plan[name] = {**settings, "run.seed": seed}
            run_folder(out / name, value, **run)
    (out / "batch.json").write_text(json.dumps({"cells": plan}))
    return list(plan)


PRESETS = [
    ({"scenario": "a", "search.preset": "race"}, [10.0, 14.0, 11.0, 13.0, 12.0]),
    ({"scenario": "a", "search.preset": "lin-lee-1999"}, [1.0, 2.0, 12.5, 4.0, 3.0]),
    ({"scenario": "a", "search.preset": "third"}, [5.0, 5.0, 6.0, 0.0, 5.0]),
    ({"scenario": "b", "search.preset": "race"}, [0.0, 0.0, 0.0]),
]


def test_groups_by_hand(tmp_path):
    batch_folder(tmp_path, PRESETS)
    groups = grouped(runs_below(tmp_path))
    told = [
        (group.number, group.task, *group.settings.values(), *group.quartiles) for group in groups
    ]
    assert told == [
        (1, "a", "a", "race", 11.0, 12.0, 13.0),
        (2, "a", "a", "third", 5.0, 5.0, 5.0),
        (3, "a", "a", "lin-lee-1999", 2.0, 3.0, 4.0),
        (4, "b", "b", "race", 0.0, 0.0, 0.0),
    ]
    assert groups[2].label == "3: preset lin-lee-1999"


def test_comparisons_against_enumeration_and_scipy(tmp_path):
    batch_folder(tmp_path, PRESETS)
    found = compared(grouped(runs_below(tmp_path)))
    assert [(item.first.number, item.second.number) for item in found] == [(1, 2), (1, 3), (2, 3)]
    for item in found:
        x, y = item.first.scores, item.second.scores
        assert item.p == scipy.stats.mannwhitneyu(x, y).pvalue
        assert item.a12 == sum((a > b) + 0.5 * (a == b) for a in x for b in y) / 25
    # 1 and 3 have no ties: p is the share of the 252 ways to deal ten ranks that differ as much
    x, y = found[1].first.scores, found[1].second.scores
    every = np.concatenate([x, y])

    def wins(own):
        others = [k for k in range(10) if k not in own]
        return sum(every[a] > every[b] for a in own for b in others)

    seen = abs(wins(range(5)) - 12.5)
    as_far = [abs(wins(own) - 12.5) >= seen for own in itertools.combinations(range(10), 5)]
    assert found[1].p == pytest.approx(np.mean(as_far), rel=1e-12)
    p = sorted(item.p for item in found)
    corrected = sorted(item.holm for item in found)
    assert corrected[0] == 3 * p[0]
    assert corrected[1] == max(3 * p[0], 2 * p[1])


def test_holm_by_hand():
    # 0.01 * 4; 0.02 * 3; 0.03 * 2 is less than that, so the same; 0.9 * 1
    assert holm(np.array([0.03, 0.01, 0.9, 0.02])) == pytest.approx([0.06, 0.04, 0.9, 0.06])
    assert holm(np.array([0.8, 0.7])) == pytest.approx([1.0, 1.0])
    assert len(holm(np.empty(0))) == 0


def test_how_few_runs_are_too_few():
    assert smallest_p(4, 4) == pytest.approx(2 / 70)
    assert smallest_p(1, 1) == 1.0
    assert smallest_p(5, 5) == scipy.stats.mannwhitneyu(range(5), range(5, 10)).pvalue
    assert runs_needed(1) == 4  # 3 and 3: 2/20
    assert runs_needed(3) == 5  # 3 * 2/70 is too much, 3 * 2/252 is not


def test_few_runs_are_said_to_be_few(tmp_path):
    batch_folder(tmp_path, [({"search.preset": name}, [1.0, 2.0, 3.0]) for name in ("a", "b")])
    assert hfc("report", tmp_path).exit_code == 0
    text = " ".join((tmp_path / "report.html").read_text().split())
    assert "1 comparison needs at least 4 runs in each group" in text
    assert "no difference can be shown" in text
    assert "difference</th>" not in text  # a table of pairs that says nothing
    assert "In 2 of 2 groups fewer than five runs" in text


def test_a_seed_run_twice_counts_once(tmp_path):
    for name, seed in (("one", 0), ("two", 0), ("three", 1)):
        run_folder(tmp_path / name, 1.0 + seed)
        (tmp_path / name / "config.toml").write_text(f'name = "mine"\n[run]\nseed = {seed}\n')
    (group,) = grouped(runs_below(tmp_path))
    assert group.scores.tolist() == [1.0, 2.0]
    assert len(group.runs) == 3
    assert hfc("report", tmp_path).exit_code == 0
    assert "settings and seed (1)" in (tmp_path / "report.html").read_text()


def test_runs_outside_of_batches_are_told_apart_by_their_configuration(tmp_path):
    """What only the scenario explains is no setting; what differs inside a scenario is."""
    configs = {
        "x/a": 'name = "ramp"\n[search]\npopulation = 10\n[load]\nconstant = 0.0\n',
        "x/b": 'name = "ramp"\n[search]\npopulation = 20\n[load]\nconstant = 0.0\n',
        "c": 'name = "cut"\n[search]\npopulation = 10\n[load]\nconstant = 5.0\n',
    }
    for name, text in configs.items():
        run_folder(tmp_path / name, 1.0)
        (tmp_path / name / "config.toml").write_text(text + "[run]\nseed = 0\n")
    batch_folder(tmp_path / "y", [({"scenario": "sine"}, [3.0])])
    runs = runs_below(tmp_path)
    assert [run.path for run in runs] == ["y/" + "0" * 16, "c", "x/a", "x/b"]
    assert [group.settings for group in grouped(runs)] == [
        {"scenario": "sine", "search.population": "–"},
        {"scenario": "cut", "search.population": "10"},
        {"scenario": "ramp", "search.population": "10"},
        {"scenario": "ramp", "search.population": "20"},
    ]


def test_a_damaged_configuration_belongs_to_no_group(tmp_path):
    for name, text in (("one", 'name = "mine"\n[run]\nseed = 3\n'), ("two", "name = ")):
        run_folder(tmp_path / name, 1.0)
        (tmp_path / name / "config.toml").write_text(text)
    (tmp_path / "loop").symlink_to(tmp_path)
    run_folder(tmp_path / "three", 1.0)
    assert hfc("report", tmp_path).exit_code == 0
    found = [(r["run"], r["group"], r["state"], r["reason"]) for r in table(tmp_path / "runs.csv")]
    assert found[0] == ("one", "1", "finished", "")
    assert found[1] == ("three", "", "unreadable", "config.toml: No such file or directory")
    assert found[2][:3] == ("two", "", "unreadable")
    assert found[2][3].startswith("config.toml: Invalid value")
    assert len(found) == 3


def test_scores_of_different_fitness_are_not_compared(tmp_path):
    groups = [({"fitness.worst": worst}, [1.0, 2.0, 3.0]) for worst in (0.1, 0.3)]
    batch_folder(tmp_path, groups)
    found = grouped(runs_below(tmp_path))
    tasks = ["c-axis-ramp, fitness.worst 0.1", "c-axis-ramp, fitness.worst 0.3"]
    assert [group.task for group in found] == tasks
    assert compared(found) == []


DAMAGED = {
    "no JSON": ("design.json", "{", "design.json: "),
    "no score": ("design.json", "{}", "has no score"),
    "a list": ("design.json", "[]", "has no score"),
    "nan": ("design.json", '{"score": {"fitness": NaN}}', "no fitness that is a number"),
    "a word": ("design.json", '{"score": {"fitness": "high"}}', "no fitness that is a number"),
    "not UTF-8": ("design.json", b"\xff", "design.json: "),
    "empty": ("history.csv", "", "history.csv: has no column best"),
    "head": ("history.csv", "generation,best\n", "no generation"),
    "cut": ("history.csv", "generation,best,median\n0,1.0,1.0\n1,1.", "row 3 is damaged"),
    "lost": ("history.csv", "generation,best\n0,1.0\n2,1.0\n", "row 3 is damaged"),
    "a folder": ("history.csv", None, "history.csv: Is a directory"),
    "words": ("history.csv", "generation,best\n0,one\n", "could not convert"),
    "infinite": ("history.csv", "generation,best\n0,inf\n", "no number"),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_what_is_damaged_is_listed_and_stops_nothing(case, tmp_path):
    file, content, words = DAMAGED[case]
    names = batch_folder(tmp_path, [({}, [1.0, 2.0, 3.0])])
    path = tmp_path / names[1] / file
    path.unlink()
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert hfc("report", tmp_path).exit_code == 0
    runs = table(tmp_path / "runs.csv")
    assert words in runs[1]["reason"]
    assert [run["reason"] for run in runs[::2]] == ["", ""]
    unread = file == "design.json"
    assert runs[1]["state"] == ("unreadable" if unread else "finished")
    (group,) = table(tmp_path / "groups.csv")
    assert (group["runs"], group["finished"]) == ("3", "2" if unread else "3")
    page = (tmp_path / "report.html").read_text()
    assert words in page


def test_what_has_not_finished_is_listed_with_its_reason(tmp_path):
    names = batch_folder(tmp_path, [({}, [1.0] * 5)])
    for name in names[1:]:
        (tmp_path / name / "design.json").unlink()
    (tmp_path / ".batch").mkdir()
    (tmp_path / ".batch" / f"{names[1]}.failed").write_text(f"RunError: {HOSTILE}\n")
    (tmp_path / names[2] / "config.toml").touch()
    shutil.rmtree(tmp_path / names[4])
    run_folder(tmp_path / "elsewhere", 1.0)  # not in the plan
    assert hfc("report", tmp_path).exit_code == 0
    found = [(run["state"], run["reason"]) for run in table(tmp_path / "runs.csv")]
    assert found == [
        ("finished", ""),
        ("failed", f"RunError: {HOSTILE}"),
        ("broken off", "after 3 generations"),
        ("waiting", ""),
        ("waiting", ""),
    ]
    text = (tmp_path / "report.html").read_text()
    assert "5 runs: 1 finished, 1 failed, 1 broken off, 2 waiting." in text


def test_nothing_has_finished(tmp_path):
    batch_folder(tmp_path, [({}, [1.0])])
    shutil.rmtree(tmp_path / ("0" * 16))
    assert hfc("report", tmp_path).exit_code == 0
    assert "No run has finished." in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({}, ["holds no runs", "batch.json"]),
        ({"notes.txt": "hello"}, ["holds no runs"]),
        ({"batch.json": "{"}, ["batch.json", "cannot be read"]),
        ({"batch.json": "[1]"}, ["batch.json", "table of keys"]),
        ({"config.toml": ""}, ["holds no finished run", "design.json"]),
        ({"design.json": "{}"}, ["holds no finished run", "config.toml"]),
    ],
)
def test_folders_that_cannot_be_reported(files, words, tmp_path):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    found = hfc("report", tmp_path)
    assert found.exit_code == 2
    assert found.stderr.count("\n") == 1
    for word in [str(tmp_path), *words]:
        assert word in found.stderr
    assert not (tmp_path / "report.html").exists()
    assert "is no folder" in hfc("report", tmp_path / "none").stderr


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses = Counter(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags[tag] += 1
        self.addresses += [value for key, value in attributes if key in ("src", "href")]


def test_hostile_settings_are_only_text(tmp_path):
    folder = tmp_path / "<i>"
    names = batch_folder(folder, [({"description": HOSTILE + str(k)}, [k, 9.0]) for k in (2, 3)])
    (folder / names[0] / "report.html").touch()
    assert hfc("report", folder).exit_code == 0
    text = (folder / "report.html").read_text()
    page = Page(text)
    assert page.tags["script"] == 1
    assert page.tags["i"] == 0
    assert "alert(&#34;1&#34;)" in text
    assert page.tags["figure"] == 2
    assert [address for address in page.addresses if not address.startswith("data:image/svg")] == [
        f"{names[0]}/report.html"
    ]


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """2,000 runs: 2 scenarios, 20 groups each, 50 seeds, 200 generations."""
    out = tmp_path_factory.mktemp("large")
    random = np.random.default_rng(1)
    grid = itertools.product(("c-axis-ramp", "c-axis-step"), range(20))
    batch_folder(
        out,
        [
            (
                {"scenario": scenario, "search.population": 10 * k},
                random.lognormal(k, 2, 50).tolist(),
            )
            for scenario, k in grid
        ],
        generations=200,
    )
    assert hfc("report", out).exit_code == 0
    return out


def test_two_thousand_runs_stay_readable(large):
    text = (large / "report.html").read_text()
    page = Page(text)
    assert len(text) < 2_000_000
    assert page.tags["tr"] > 2000
    assert page.tags["figure"] == 4
    assert all(address.startswith("data:image/svg+xml") for address in page.addresses)
    assert len(table(large / "comparisons.csv")) == 2 * 190
    assert "280 more are in <code>comparisons.csv" in text
    assert text.index("<h2>Groups") < text.index("<h2>Every run")


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


def test_same_runs_same_bytes(large):
    names = ("report.html", "runs.csv", "groups.csv", "comparisons.csv")
    before = {name: (large / name).read_bytes() for name in names}
    command = [sys.executable, "-m", "hfc_design", "report", large]
    assert subprocess.run(command, stdout=subprocess.DEVNULL, check=True).returncode == 0
    assert before == {name: (large / name).read_bytes() for name in names}


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
    found = hfc("report", tmp_path, "--parquet")
    assert found.exit_code == 2
    assert "pip install 'hfc-design[parquet]'" in found.stderr
    assert not (tmp_path / "runs.csv").exists()


def test_the_page_of_a_run_is_that_of_hfc_design(tmp_path):
    """A cell of a batch has none; what is written later is what hfc design writes at once."""
    (tmp_path / "mine.toml").write_text(TINY)
    out = tmp_path / "out"
    assert hfc("batch", tmp_path / "mine.toml", "--out", out).exit_code == 0
    assert list(out.glob("*/report.html")) == []
    assert hfc("report", out, "--each").exit_code == 0
    pages = sorted(out.glob("*/report.html"))
    assert len(pages) == 4
    assert all(
        f'href="{p.parent.name}/report.html"' in (out / "report.html").read_text() for p in pages
    )
    own = pages[0].parent
    assert hfc("design", own / "config.toml", "--out", tmp_path / "again", "--quiet").exit_code == 0
    for file in ("report.html", "tables/manifest.csv", "design.json"):
        assert (own / file).read_bytes() == (tmp_path / "again" / file).read_bytes()
    first = pages[0].read_bytes()
    pages[0].write_text("old")
    assert hfc("report", own).exit_code == 0
    assert pages[0].read_bytes() == first
    assert "--each" in hfc("report", own, "--each").stderr
    (own / "checkpoint.npz").unlink()
    assert "is gone" in hfc("report", own).stderr
    pages[0].unlink()
    found = hfc("report", out, "--each")
    assert found.exit_code == 1
    assert "1 of the runs got no page of their own" in found.stderr


@pytest.mark.browser
def test_the_page_on_a_phone(large, tmp_path):
    assert phone.figures_that_fit(large / "report.html", tmp_path) == 4


ACTIONS = """<script>
const buttons = [...document.querySelectorAll("#all button")];
const button = buttons.find((one) => one.textContent == "fitness");
const rows = () => [...body.rows].filter((row) => !row.hidden);
const shown = () => rows().map((row) => row.cells[0].textContent);
const told = [];
button.click(); told.push(shown());
button.click(); told.push(shown());
search.value = "RACE finished"; search.oninput(); told.push(shown());
document.body.innerHTML = "<pre>" + JSON.stringify(told) + "</pre>";
</script>"""


@pytest.mark.browser
def test_sorting_and_searching(tmp_path):
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no chromium on the PATH")
    values = [200.0, 30.0, 4.0]
    names = batch_folder(
        tmp_path / "out", [({"search.preset": p}, values[:n]) for p, n in (("race", 2), ("x", 3))]
    )
    (tmp_path / "out" / names[0] / "design.json").unlink()
    assert hfc("report", tmp_path / "out").exit_code == 0
    page = tmp_path / "acting.html"
    page.write_text((tmp_path / "out" / "report.html").read_text() + ACTIONS)
    options = f"--headless --no-sandbox --disable-gpu --user-data-dir={tmp_path}/profile --dump-dom"
    done = subprocess.run(
        [chromium, *options.split(), page.as_uri()],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    told = json.loads(re.search("<pre>(.*)</pre>", done.stdout)[1])
    a, b, c, d, e = names  # fitness: none (not finished), 30, 200, 30, 4
    assert told == [[e, b, d, c, a], [c, b, d, e, a], [b]]
