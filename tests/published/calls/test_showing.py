"""What functions of the API return is drawn by plot, and shows itself."""

import re
import xml.etree.ElementTree as ET
from itertools import pairwise

import pytest
from matplotlib.figure import Figure

import hfc_design.api as hfc

SHORT = {"simulation.duration_s": 0.1}
SMALL = {**SHORT, "search.population": 4, "search.generations": 2, "controller": {"kind": "pd"}}
AHEAD = {"velocity": 13.6, "acceleration": 28.0, "coulomb": 3.6, "coulomb_width": 0.003}
GAINS = {"kp": 1900.0, "ki": 1500.0, "kd": 450.0, "feed_forward": AHEAD}


RAMP = {"name": "a", "simulation": {"duration_s": 0.1}}
PUBLISHED = "lin-lee-1999-table-1"
FOUND = {
    "evaluation": lambda: hfc.evaluate("pd-only", hfc.load_scenario("c-axis-ramp", SHORT)),
    "result": lambda: hfc.design(hfc.load_scenario("c-axis-ramp", SMALL)),
    "robustness": lambda: hfc.robustness("pd-only", RAMP, 0.1, 4),
    "usable": lambda: hfc.usable("pd-only", RAMP, machines=4),
    "comparison": lambda: hfc.compare([PUBLISHED, "pd-only"], [RAMP], machines=4),
    "range": hfc.stability,
    "margins": lambda: hfc.stability(hfc.with_gains("c-axis-ramp", "pid+ff", GAINS)),
}


@pytest.mark.parametrize("kind", FOUND)
def test_a_figure_that_shows_itself_and_is_written_where_it_is_asked_for(kind, tmp_path):
    found = FOUND[kind]()
    figure = hfc.plot(found)
    assert isinstance(figure, Figure)
    assert [*tmp_path.iterdir()] == []
    bundle, _ = figure._repr_mimebundle_()
    (picture,) = bundle.keys() - {"text/plain"}
    if picture == "image/svg+xml":
        assert ET.fromstring(bundle[picture]).tag.endswith("svg")
        assert len(bundle[picture]) < 100_000
    hfc.plot(found, tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("kind", "title"),
    [("robustness", "rms error [mrad]"), ("usable", "settled rms error\n[mrad]")],
)
def test_on_many_machines_in_a_column_every_text_is_whole_and_no_numbers_touch(kind, title):
    figure = hfc.plot(FOUND[kind](), width="88mm")
    figure.draw_without_rendering()
    seen = [axes for axes in figure.axes if axes.get_visible()]
    assert title in [axes.get_title(loc) for axes in seen for loc in ("center", "right")]
    for axes in seen:
        for label in (axes.yaxis.label, axes.title):
            box = label.get_window_extent()
            assert box.x0 >= 0
            assert box.x1 <= figure.bbox.width
        low, high = axes.get_xlim()
        ticks = zip(axes.get_xticks(), axes.get_xticklabels(), strict=True)
        boxes = [label.get_window_extent() for x, label in ticks if low <= x <= high]
        assert all(b.x0 - a.x1 > 3 for a, b in pairwise(boxes))


PAPER = {"figures": "pdf", "width": "88mm", "latex": True}


def test_a_page_for_a_paper_has_what_the_command_writes(tmp_path):
    short = hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})
    hfc.report("pd-only", tmp_path / "a.html", scenario=short, **PAPER)
    (box,) = re.findall(
        rb"/MediaBox \[([^\]]*)\]", (tmp_path / "a-figures/response.pdf").read_bytes()
    )
    assert float(box.split()[2]) == pytest.approx(88 / 25.4 * 72)
    assert "pd-only on c-axis-ramp" in (tmp_path / "a-latex/scores.tex").read_text()
    found = hfc.compare(["pd-only", "lin-lee-1999-table-1"], [short], 0.2, 3)
    hfc.comparison_page(found, tmp_path / "b.html", **PAPER)
    assert r"\textbf" in (tmp_path / "b-latex/c-axis-ramp.tex").read_text()
    assert (tmp_path / "b-figures/machines.pdf").exists()
    for wrong, why in [
        ({"width": "88mm"}, "width: applies to figures"),
        ({"figures": "png"}, "figures='png': must be one of pdf, svg, pgf"),
        ({"figures": "pdf", "width": 88}, "width=88: must be a number with a unit"),
    ]:
        with pytest.raises(hfc.UserError, match=why):
            hfc.report("pd-only", tmp_path / "c.html", scenario=short, **wrong)
