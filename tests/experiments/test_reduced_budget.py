"""Searches of published experiments at a reduced budget: already that beats what was published."""

import pytest
from click.testing import CliRunner
from experiment_pages import EXPERIMENTS

from experiments import shared
from experiments.designed_tables import page as designed_tables
from hfc_design.cli import main

pytestmark = pytest.mark.slow


def test_lin_lee_at_a_reduced_budget(tmp_path):
    """The tables score what an independent program found; 15 generations already beat them."""
    file = EXPERIMENTS / "lin_lee_1999/batch.toml"
    small = ("--set", "search.generations=15", "--set", "run.seed=0")
    found = CliRunner().invoke(main, ["batch", str(file), "--out", str(tmp_path), *small])
    assert found.exit_code == 0, found.output
    batch = shared.Batch(tmp_path)

    def fitness(label):
        return batch.values(label, "fitness")[0]

    assert fitness("Table I") == pytest.approx(380.5715, rel=1e-6)
    assert fitness("PD of Table I") == pytest.approx(80.0197, rel=1e-6)
    assert fitness("Table II") == pytest.approx(22.0256, rel=1e-5)
    assert fitness("PD of Table II") == pytest.approx(10.4647, rel=1e-5)
    assert fitness("the paper's algorithm") > 2 * fitness("Table I")
    assert fitness("the default search") > 5 * fitness("Table I")
    assert fitness("the paper's algorithm, cutting") > fitness("Table II")
    assert fitness("the default search, cutting") > 5 * fitness("Table II")


def test_designed_tables_at_a_reduced_budget(tmp_path, monkeypatch):
    """Already a fourteenth of the search beats both tables of 2004, as the page says."""
    sizes = "[set]\nsearch.population = 64\nsearch.generations = 30\n"
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
        own = float(rms[path, "designed AFLC"])
        assert own < float(rms[path, "AFLC of 2004"])
        assert own < float(rms[path, "FLC of 2004"])
    page = (EXPERIMENTS / "designed_tables/README.md").read_text(encoding="utf-8")
    for (path, name), value in rms.items():
        if "2004" in name:
            assert f"| {path} | {name} | {value.strip()} |" in page
