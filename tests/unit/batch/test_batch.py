"""A batch: its cells, what it leaves on disk, and what happens when something goes wrong."""

import pytest
from batches import GRID, TINY, batch, written
from wording import refused, refused_command

from hfc_design.batch.plan import read_batch


def test_cells_are_the_grid_and_the_list(tmp_path):
    text = f"{GRID}[[cells]]\nplant.parameters.spindle_inertia = 6.5\n[[cells]]\nrun.seed = 9\n"
    cells = read_batch(written(tmp_path, text)).cells
    # 2 scenarios x 2 seeds with the inertia; the second cell's own seed wins, so 2 of 4 are one
    assert len(cells) == 4 + 2
    assert len({cell.name for cell in cells}) == 6
    assert {cell.scenario.run.seed for cell in cells} == {0, 1, 9}
    assert cells[0].scenario.plant.parameters == {"spindle_inertia": 6.5}
    assert all(cell.scenario.search.population == 12 for cell in cells)


def test_the_name_is_that_of_the_whole_configuration(tmp_path):
    """Also of what stands in the files that it names, and not of where they lie."""

    def names(where, angle):
        (tmp_path / where).mkdir(exist_ok=True)
        (tmp_path / where / "r.csv").write_text(f"t,a\n0,0\n1,{angle}\n")
        scenario = '[reference]\nkind = "csv"\nfile = "r.csv"\n'
        written(tmp_path / where, scenario, "own.toml")
        text = f'{TINY}\n[grid]\nscenario = ["own.toml"]\n'
        return [cell.name for cell in read_batch(written(tmp_path / where, text)).cells]

    assert names("a", 0.01) == names("b", 0.01)
    assert names("a", 0.01) != names("a", 0.02)


def test_dry_run_touches_nothing(tmp_path):
    found = batch(written(tmp_path, GRID), "--out", tmp_path / "out", "--dry-run")
    assert found.exit_code == 0
    assert "c-axis-ramp-cutting" in found.output
    assert "to go" in found.output
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "text",
    [
        "[grid]\nrun.seed = 3\n",
        '[grid]\nscenario = ["nobody"]\n',
        "[grid]\nsearch.speed = [1]\n",
        f"[grid]\nrun.seed = {list(range(400))}\nsearch.generations = {list(range(1, 400))}\n",
        "",
    ],
)
def test_batch_files_that_cannot_be_run(text, tmp_path):
    path = written(tmp_path, text)
    with refused() as found:
        read_batch(path)
    assert found.where.startswith(str(path))
    assert batch(path).exit_code == 2


def test_a_folder_without_a_batch(tmp_path):
    assert refused_command("batch", "--status", tmp_path).where == str(tmp_path)
    refused_command("batch", "a.toml", "--status", tmp_path)
    refused_command("batch")


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
