"""The page of many runs, and the page of one that was run without."""

import pytest
from run_folders import hfc

TINY = """
[set]
search.population = 16
search.generations = 3
simulation.duration_s = 0.1
controller.inputs = [{name = "error", scale = 50.0}, {name = "deflection", scale = 80.0}]
[grid]
run.seed = [0, 1]
"""


@pytest.mark.usefixtures("no_baselines")
def test_the_page_of_a_run_is_that_of_hfc_design(tmp_path):
    """A cell of a batch has none; what is written later is what hfc design writes at once."""
    (tmp_path / "mine.toml").write_text(TINY)
    out = tmp_path / "out"
    assert hfc("batch", tmp_path / "mine.toml", "--out", out).exit_code == 0
    assert list(out.glob("*/report.html")) == []
    assert hfc("report", out, "--each").exit_code == 0
    pages = sorted(out.glob("*/report.html"))
    assert len(pages) == 2
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
    assert "is missing" in hfc("report", own).stderr
    pages[0].unlink()
    found = hfc("report", out, "--each")
    assert found.exit_code == 1
    assert "1 of the runs could not get a page" in found.stderr
