"""The experiments of Jee & Koren 1995: figures that must hold, and that their page shows them."""

import pytest
from click.testing import CliRunner
from experiment_pages import EXPERIMENTS, page_of, ran, simulated, stands_in, table

from experiments.jee_koren_1995 import page as jk95
from hfc_design.files.pairing import load_design


@pytest.fixture(scope="module")
def batch_95(tmp_path_factory):
    return ran(tmp_path_factory.mktemp("jk95"), "jee_koren_1995/batch.toml")


@pytest.mark.slow
def test_published_figures_of_1995(batch_95):
    stands_in(jk95, batch_95.published())
    assert len(batch_95.published()) == 24
    values = simulated(batch_95)
    assert values["SOFLC: contour RMS, cycle 3 [BLU]"] > 3.0  # 1.23 in the paper: not reached


@pytest.mark.parametrize(("letter", "terms", "centroids"), [("a", 0.63, 3.0), ("b", 0.47, 2.0)])
def test_narrow_starts_are_what_their_labels_say(letter, terms, centroids):
    for kind, name in (("flc", "jee-koren-2004-flc"), ("soflc", "jee-koren-1995-soflc")):
        path = EXPERIMENTS / f"jee_koren_1995/{kind}-narrow-{letter}.json"
        own, built_in = (load_design(str(item)).controller for item in (path, name))
        middles = [term.centre for term in built_in.error_terms]
        assert [term.centre for term in own.error_terms] == [terms * x for x in middles]
        assert own.error_change_terms == built_in.error_change_terms
        for row, base in zip(own.rules.centroids, built_in.rules.centroids, strict=True):
            assert list(row) == [centroids * u for u in base]


@pytest.mark.slow
def test_jk95_blames_other_rules_than_jk04(batch_95):
    first = [
        batch_95.values(f"blame of {paper}, overlap 5 and 1 BLU, range", jk95.CYCLES[0])[0]
        for paper in ("JK95", "JK04")
    ]
    assert first[0] > 1.3 * first[1]  # JK95's second case costs the first cycle


@pytest.mark.slow
def test_every_variant_stands_in_its_page(batch_95):
    first = [line[0] for line in table(page_of(jk95))]
    printed = [line[0] for line in table(jk95.variants(batch_95))]
    assert len(printed) > 20
    assert [name for name in printed if name not in first] == []


@pytest.mark.slow
def test_the_page_of_1995_is_what_its_command_prints(batch_95):
    found = CliRunner().invoke(jk95.main, ["--runs", str(batch_95.folder)])
    assert found.exit_code == 0, found.output
    assert 10_000 < (batch_95.folder / "fig-03-04.svg").stat().st_size < 60_000
    printed, page = table(found.stdout), table(page_of(jk95))
    assert len(printed) > 45
    assert [row[:3] for row in printed] == [row[:3] for row in page][: len(printed)]
