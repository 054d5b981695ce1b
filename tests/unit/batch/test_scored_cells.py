"""Cells of a batch that score a given design, and the published figures beside them."""

import pytest
from batches import batch, written
from wording import refused

from hfc_design.batch.plan import read_batch

SHORT = "[set]\nsimulation.duration_s = 0.2\n"


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
    ("entry", "where"),
    [
        ('metric = "b", of = "c"', ""),
        ('metric = "max_eror_rad", of.run.seed = 0', ""),
        ('metric = "b"', ".of"),
        ('metric = "b", of = "c", worth = 1.0', ".worth"),
    ],
)
def test_published_figures_that_cannot_be(entry, where, tmp_path):
    entry = f'{{ quantity = "a", {entry} }}'
    path = written(tmp_path, f"published = [{entry}]\n[set]\nrun.seed = 0\n")
    with refused() as found:
        read_batch(path)
    assert f": published.0{where}" in found.refusal


@pytest.mark.parametrize(
    "text",
    [
        "change.controller.pd.kp = 4.0",
        'design = "nope"',
        'design = "pd-only"\nchange.controller.pd.kx = 4.0',
        'design = "pd-only"\nscenario = "milling-table-circle"',
        "label = 3",
        'label = "a\\u001bb"',
    ],
)
def test_cells_that_cannot_be(text, tmp_path):
    path = written(tmp_path, f"[set]\n{text}\n")
    with refused() as found:
        read_batch(path)
    assert found.where == str(path)
    assert "cell with" in found.refusal
