"""The experiment of Lin & Lee: what is said of Figs. 5 to 7."""

from itertools import product

import pytest
from experiment_pages import page_of, ran, table

from experiments.lin_lee_1999 import page, pictures
from experiments.lin_lee_1999.pictures import SEVEN, SIX
from hfc_design.controllers.hierarchical.tree import decode
from hfc_design.files.loop_setup import load_design


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    """The printed tables and their PD gains alone."""
    out = tmp_path_factory.mktemp("runs") / "lin-lee"
    return ran(out, "lin_lee_1999/batch.toml", lambda cell: cell.design is not None)


def test_the_code_of_figure_5_is_refused():
    """A, C and the output of unit 1 enter unit 0: three."""
    assert decode((0, 1, 2, 3)) is None
    assert decode((0, 1, 3, 3)) is not None  # C and D enter unit 3, which feeds unit 1 with B
    kept = [found for code in product(range(4), repeat=4) if (found := decode(code))]
    assert (len(kept), len({*kept})) == (48, 15)
    text = " ".join(page_of(page).split())
    assert "Of the 256 codes of four inputs 48 are kept, for 15 hierarchies" in text


@pytest.mark.parametrize("case", [SIX, SEVEN])
def test_the_page_has_what_comes_out_of_the_printed_tables(batch, case):
    """Fitness as an independent implementation has it: 380.57, 80.02, 22.03, 10.46."""
    wanted = {"Table I": [380.57, 80.02], "Table II": [22.03, 10.46]}[case.table]
    shown = table(page_of(page))
    rows = table(page.motions(batch, case))[2:]
    assert [row[0] for row in rows] == [case.table, "PD alone"]
    for row, fitness in zip(rows, wanted, strict=True):
        assert row in shown
        assert float(row[1]) == pytest.approx(fitness, abs=0.06)


def test_figures_are_drawn_of_the_printed_tables(batch):
    figure = pictures.motion(batch, SEVEN)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "Table II",
        "PD alone",
        "reference",
    ]
    assert pictures.tree(SIX).axes
    assert len(pictures.code().axes) == 2


def test_no_search_of_the_page_ended_with_a_printed_hierarchy():
    told = [row[1] for row in table(page_of(page)) if len(row) == 6 and row[1].startswith("((")]
    assert len(told) == 16
    for case in (SIX, SEVEN):
        design = load_design(case.design)
        assert design.kind.structure(design.controller) not in told
