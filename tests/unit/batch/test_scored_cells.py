"""Cells of a batch that score a given design, and the published figures beside them."""

import csv
import json

import pytest
from batches import batch, written

from hfc_design.batch.plan import read_batch
from hfc_design.core.records import UserError

SHORT = "[set]\nsimulation.duration_s = 0.2\n"
CELLS = """
[[cells]]
label = "weak"
scenario = "c-axis-ramp"
design = "pd-only"
change.controller.pd.kp = 400.0
[[cells]]
label = "strong"
scenario = "c-axis-ramp"
design = "pd-only"
[[cells]]
label = "cutting"
scenario = "c-axis-ramp-cutting"
design = "pd-only"
"""
PUBLISHED = """
published = [
    { quantity = "w", value = 2e-3, metric = "max_error_rad", remark = "b", of = "weak" },
    { figure = "1", quantity = "a", value = 4.0, metric = "fitness", of = "strong", over = "weak" },
    { quantity = "one run", metric = "max_error_rad", of = "weak", over_metric = "rms_error_rad" },
    { quantity = "never", value = 1.0, metric = "settling_time_s", of = "weak" },
    { quantity = "median", value = 0.0, metric = "max_error_rad", of.scenario = "c-axis-ramp" },
]
"""


def scores(out):
    """Score by label."""
    plan = json.loads((out / "batch.json").read_text())["cells"]
    return {
        settings["label"]: json.loads((out / name / "design.json").read_text())["score"]
        for name, settings in plan.items()
    }


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    path = tmp_path_factory.mktemp("scored")
    found = batch(written(path, PUBLISHED + SHORT + CELLS), "--out", path / "out")
    assert found.exit_code == 0, found.output
    return path / "out"


def test_published_figures_by_hand(out):
    with (out / "published.csv").open(newline="") as file:
        weak, ratio, inside, missing, median = csv.DictReader(file)
    found = scores(out)
    largest = {label: found[label]["max_error_rad"] for label in found}
    assert (ratio["figure"], weak["remark"]) == ("1", "b")
    assert float(weak["simulated"]) == largest["weak"]
    assert float(weak["ratio"]) == pytest.approx(largest["weak"] / 2e-3)
    better = found["strong"]["fitness"] / found["weak"]["fitness"]
    assert float(ratio["simulated"]) == pytest.approx(better)
    assert float(ratio["ratio"]) == pytest.approx(better / 4.0)
    assert float(inside["simulated"]) == largest["weak"] / found["weak"]["rms_error_rad"]
    assert (inside["published"], inside["ratio"]) == ("", "")
    middle = (largest["weak"] + largest["strong"]) / 2
    assert float(median["simulated"]) == pytest.approx(middle)
    assert (median["runs"], median["ratio"]) == ("2", "")
    assert (missing["simulated"], missing["runs"]) == ("", "0")


def test_seeds_of_a_given_design_are_one_run(tmp_path):
    text = f"{SHORT}[grid]\nrun.seed = [0, 1, 2]\nsearch.population = [8, 16]\n"
    text += '[[cells]]\ndesign = "pd-only"\n[[cells]]\n'
    cells = read_batch(written(tmp_path, text)).cells
    assert [cell.design is None for cell in cells].count(True) == 6
    assert [cell.design is None for cell in cells].count(False) == 2  # search.population is kept


def test_changes_for_every_cell(tmp_path):
    path = written(tmp_path, "[grid]\nrun.seed = [0, 1]\nsearch.generations = [5, 6]\n")
    cells = read_batch(path, ["search.generations=2"]).cells
    assert [cell.scenario.run.seed for cell in cells] == [0, 1]
    assert {cell.scenario.search.generations for cell in cells} == {2}
    found = batch(path, "--dry-run", "--set", "run.seed=7")
    assert "2 cells" in found.output


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ('{ quantity = "a", metric = "b", of = "c" }', "published.0: no cell has label = 'c'"),
        (
            '{ quantity = "a", metric = "fitness", of.run.seed = 0, over = { run.seed = 5 } }',
            "published.0: no cell has run.seed = 5",
        ),
        (
            '{ quantity = "a", metric = "max_eror_rad", of.run.seed = 0 }',
            "published.0: 'max_eror_rad' is no metric of these cells; did you mean max_error_rad",
        ),
        (
            '{ quantity = "a", metric = "fitness", of.run.seed = 0, over_metric = "nope" }',
            "published.0: 'nope' is no metric of these cells; there is fitness, merit, rms_",
        ),
        (
            '{ quantity = "a", metric = "fitness", of.run.seed = 0, over = 5 }',
            "published.0.over = 5: has to be a table of keys and values",
        ),
        ('{ quantity = "a", metric = "b" }', "published.0.of: is missing"),
        ('{ quantity = "a", metric = "b", of = "c", value = nan }', "published.0.value = nan"),
        ('{ quantity = "a", metric = "b", of = "c", worth = 1.0 }', "published.0.worth"),
    ],
)
def test_published_figures_that_cannot_be(entry, told, tmp_path):
    path = written(tmp_path, f"published = [{entry}]\n[set]\nrun.seed = 0\n")
    with pytest.raises(UserError) as found:
        read_batch(path)
    assert told in str(found.value)
