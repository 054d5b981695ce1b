"""A batch: its cells, what it leaves on disk, and what happens when something goes wrong."""

import pytest
from batches import QUICK, batch, files, left_behind, written

from hfc_design.batch import folder
from hfc_design.batch.plan import read_batch
from hfc_design.batch.runner import Place, run_cells
from hfc_design.core.lock import try_lock


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """What the grid leaves behind when nothing happens."""
    return left_behind(tmp_path_factory.mktemp("batch"), QUICK)


def test_a_failing_cell_stops_nothing_and_is_tried_again(tmp_path, undisturbed):
    path, out = written(tmp_path, QUICK), tmp_path / "out"
    victim = read_batch(path).cells[1].name
    (out / victim).mkdir(parents=True)
    (out / victim / "config.toml").mkdir()  # nobody can write that file
    found = batch(path, "--out", out)
    assert found.exit_code == 1
    assert "1 of 4 cells failed" in found.output
    assert victim in found.output
    status = batch("--status", out).output
    assert "3 finished, 1 failed" in status or "1 failed, 3 finished" in status
    (out / victim / "config.toml").rmdir()
    assert batch(path, "--out", out).exit_code == 0
    assert files(out) == undisturbed


def test_what_another_process_is_at_is_left_to_it(tmp_path, undisturbed):
    path, out = written(tmp_path, QUICK), tmp_path / "out"
    plan = read_batch(path)
    cells = plan.cells
    folder.note_plan(out, plan)
    seen = []

    def outcome(cell, found):
        seen.append(cell.name)
        if len(seen) == 3:  # the other three are done: now the claim is given back
            claim.__exit__(None, None, None)

    claim = try_lock(out / cells[0].name)
    assert claim.__enter__()
    assert "1 running, 3 waiting" in batch("--status", out).output
    run_cells(out, cells, Place(), outcome)
    assert seen == [cell.name for cell in (*cells[1:], cells[0])]
    assert files(out) == undisturbed


def test_cells_keep_the_names_that_an_earlier_version_gave_them(tmp_path):
    """Those of the searches that begin with searched laws, and of feed drives with L-SHADE."""
    scenarios = {
        "c-axis-ramp-cutting": "7846d048b6c6a910",
        "feed-drive-circle": "ce5b833d80ac395b",
        "feed-drive-hierarchy": "1fadf82b6370f365",
    }
    file = tmp_path / "batch.toml"
    file.write_text(f'name = "kept"\n[grid]\nscenario = {list(scenarios)}\n')
    assert [cell.name for cell in read_batch(file).cells] == list(scenarios.values())
