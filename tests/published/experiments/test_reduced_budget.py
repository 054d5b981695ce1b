"""Searches of published experiments at a reduced budget: already that beats what was published."""

import pytest
from click.testing import CliRunner
from experiment_pages import EXPERIMENTS, ran

from experiments.designed_tables import page as designed_tables
from hfc_design.cli import main


def test_lin_lee_at_a_reduced_budget(tmp_path):
    """The tables score what an independent program found; searches beat them.

    The paper's algorithm after 15 of its small generations, the default search after 5; the first
    of the five seeds of the page.
    """
    file = "lin_lee_1999/batch.toml"

    def wanted(preset):
        return lambda cell: (
            cell.scenario.search.preset == preset and cell.scenario.run.seed < 1
            if cell.design is None
            else preset != "race"
        )

    few, fewer = (f"search.generations={k}" for k in (15, 5))
    printed = ran(tmp_path / "paper", file, wanted("lin-lee-1999"), [few])
    ours = ran(tmp_path / "ours", file, wanted("race"), [fewer])

    def fitness(batch, label):
        (found,) = (run.score["fitness"] for run in batch.runs if run.settings["label"] == label)
        return found

    table_1, pd_1 = (fitness(printed, name) for name in ("Table I", "PD of Table I"))
    table_2, pd_2 = (fitness(printed, name) for name in ("Table II", "PD of Table II"))
    assert [table_1, pd_1, table_2, pd_2] == pytest.approx(
        [380.5715, 80.0197, 22.0256, 10.4647], abs=6e-5
    )
    assert fitness(printed, "the paper's algorithm") > 2 * table_1
    assert fitness(ours, "the default search") > 5 * table_1
    assert fitness(printed, "the paper's algorithm, cutting") > table_2
    assert fitness(ours, "the default search, cutting") > 5 * table_2


def test_designed_tables_at_a_reduced_budget(tmp_path, monkeypatch):
    """Already a fourteenth of the search, on its first 20 s, beats both tables of 2004."""
    sizes = "[set]\nsearch.population = 64\nsearch.generations = 30\nsimulation.duration_s = 20\n"
    cells = '[[cells]]\nscenario = "feed-drive-contour"\n'
    file = tmp_path / "small.toml"
    file.write_text(sizes + cells)
    found = CliRunner().invoke(main, ["batch", str(file), "--out", str(tmp_path / "out")])
    assert found.exit_code == 0, found.output
    paths = ("the same, first cycle", "circle R 15, 300 mm/min, clockwise")
    monkeypatch.setattr(designed_tables, "PATHS", {k: designed_tables.PATHS[k] for k in paths})
    shown = CliRunner().invoke(designed_tables.main, ["--runs", str(tmp_path / "out")])
    assert shown.exit_code == 0, shown.output
    text = shown.stdout.strip()
    rows = [line.split("|")[1:-1] for line in text.splitlines()]
    rms = {(path.strip(), name.strip()): value for path, name, value, _ in rows[2:]}
    for path in paths:
        own, *others = (
            [float(end) for end in rms[path, name].split(" to ")]
            for name in ("designed AFLC", "AFLC of 2004", "FLC of 2004")
        )
        assert max(own) < min(map(min, others))
    page = (EXPERIMENTS / "designed_tables/README.md").read_text(encoding="utf-8")
    for (path, name), value in rms.items():
        if "2004" in name:
            assert f"| {path} | {name} | {value.strip()} |" in page
