"""A batch: its cells, what it leaves on disk, and what happens when something goes wrong."""

import pytest
from batches import GRID, TINY, batch, written
from wording import refused, refused_command

from hfc_design.batch import folder
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


def test_brackets_are_no_markup(tmp_path):
    """Of units, in labels and in reasons."""
    text = f"{TINY}[[cells]]\nlabel = 'peak [rad/s] of [/b]'\n"
    path, out = written(tmp_path, text), tmp_path / "out"
    assert "label=peak [rad/s] of [/b]" in batch(path, "--out", out, "--dry-run").output
    (cell,) = read_batch(path).cells
    folder.note_plan(out, read_batch(path))
    folder.note(out, cell.name, "failed", "no [/such] thing")
    said = batch("--status", out)
    assert said.exit_code == 0
    assert "no [/such] thing" in said.output
