"""What functions of the API return is drawn by plot, and shows itself."""

import re
import xml.etree.ElementTree as ET
from itertools import pairwise

import pytest
from matplotlib.figure import Figure
from run_folders import batch_folder

import hfc_design.api as hfc

SHORT = {"simulation.duration_s": 0.1}
SMALL = {**SHORT, "search.population": 4, "search.generations": 2, "controller": {"kind": "pd"}}
AHEAD = {"velocity": 13.6, "acceleration": 28.0, "coulomb": 3.6, "coulomb_width": 0.003}
GAINS = {"kp": 1900.0, "ki": 1500.0, "kd": 450.0, "feed_forward": AHEAD}


def linear():
    return hfc.stability(hfc.with_gains("c-axis-ramp", "pid+ff", GAINS))


FOUND = {
    "evaluation": lambda: hfc.evaluate("pd-only", hfc.load_scenario("c-axis-ramp", SHORT)),
    "result": lambda: hfc.design(hfc.load_scenario("c-axis-ramp", SMALL)),
    "robustness": lambda: hfc.robustness("pd-only", {"name": "a", **RAMP}, 0.1, 4),
    "usable": lambda: hfc.usable("pd-only", {"name": "a", **RAMP}, machines=4),
    "comparison": lambda: hfc.compare([PUBLISHED, "pd-only"], [{"name": "a", **RAMP}], machines=4),
    "range": hfc.stability,
    "margins": linear,
}
RAMP = {"simulation": {"duration_s": 0.1}}
PUBLISHED = "lin-lee-1999-table-1"


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
    [("robustness", "rms error [mrad]"), ("usable", "error once settled\n[mrad]")],
)
def test_on_many_machines_in_a_column_every_text_is_whole_and_no_numbers_touch(kind, title):
    figure = hfc.plot(FOUND[kind](), width="88mm")
    figure.draw_without_rendering()
    seen = [axes for axes in figure.axes if axes.get_visible()]
    shown = [axes.get_title(loc) for axes in seen for loc in ("center", "right")]
    assert title in shown
    for axes in seen:
        for label in (axes.yaxis.label, axes.title):
            box = label.get_window_extent()
            assert box.x0 >= 0
            assert box.x1 <= figure.bbox.width
        low, high = axes.get_xlim()
        ticks = zip(axes.get_xticks(), axes.get_xticklabels(), strict=True)
        boxes = [label.get_window_extent() for x, label in ticks if low <= x <= high]
        assert all(b.x0 - a.x1 > 3 for a, b in pairwise(boxes))


def test_a_large_picture_is_drawn_in_points():
    bundle, about = hfc.picture("jee-koren-2004-flc", "surface")._repr_mimebundle_()
    assert set(bundle) <= {"image/png", "image/svg+xml", "text/plain"}
    if "image/png" in bundle:
        assert about["image/png"]["width"] == 540  # of 5.4 in


def test_a_title_stands_above():
    found = hfc.evaluate("pd-only", hfc.load_scenario("c-axis-ramp", SHORT))
    assert "on a ramp &amp; more" in hfc.plot(found, title="on a ramp & more")._repr_mimebundle_()[
        0
    ].get("image/svg+xml")


def test_what_was_not_searched_has_no_search_to_draw():
    found = hfc.evaluate("pd-only", hfc.load_scenario("c-axis-ramp", SHORT))
    given = hfc.Result(hfc.load_design("pd-only"), found, None)
    with pytest.raises(hfc.UserError, match=r"nothing was searched; plot its \.evaluation"):
        hfc.plot(given)
    with pytest.raises(hfc.UserError, match="is no evaluation"):
        hfc.plot("pd-only")


def test_the_range_of_the_published_drive():
    """Jee & Koren 2004, fig. 4, cut off at the linear limit; tables of the design within it."""
    found = hfc.stability("jee-koren-2004-flc")
    assert found.numbers()["k1_bound"] == pytest.approx(7.28786, rel=1e-5)
    assert found.range == hfc.stability(gain=28.3, time_constant=0.055).range
    assert found.points
    assert "7.28786" in found._repr_html_()
    assert repr(found).startswith("StableGains(k1_bound=7.288, ")


def test_margins_of_a_linear_loop():
    """Stable is what has all poles inside the unit circle."""
    found = linear()
    (axis,) = found.numbers()["axes"].values()
    sizes = [abs(complex(pole["real"], pole["imaginary"])) for pole in axis["poles"]]
    assert axis["stable"] == (max(sizes) < 1.0) is True
    assert re.match(r"LoopMargins\(stable=True, gain_up=", repr(found))
    assert f"{axis['phase']:.4g}" in found._repr_html_()
    with pytest.raises(hfc.UserError, match="is judged on its own drive"):
        hfc.stability(hfc.with_gains("c-axis-ramp", "pid+ff", GAINS), gain=2.0)


def test_several_motions_are_no_single_one():
    with pytest.raises(hfc.UserError, match=r"take usable.*scenario\.motion\('ramp'\)"):
        hfc.robustness("pd-only", "c-axis-tolerances", 0.2, 4)


def test_usable_shows_itself():
    found = FOUND["usable"]()
    assert repr(found).startswith("Usable(yes=")
    assert found.answer.partition(":")[0] in ("yes", "no")
    assert f"machines={len(found.good)}" in repr(found)
    assert found._repr_html_().count("<tr>") == 7  # six figures, one motion
    with pytest.raises(hfc.UserError):
        hfc.usable("pd-only", "feed-drive-line")


@pytest.mark.slow
def test_the_page_of_a_design_and_of_a_run(tmp_path):
    page = hfc.report(hfc.load_design("pd-only", {"name": "mine"}), tmp_path / "a.html")
    assert page == tmp_path / "a.html"
    assert "mine" in page.read_text("utf-8")
    hfc.design(hfc.load_scenario("c-axis-ramp", SMALL), tmp_path / "run")
    (tmp_path / "run" / "report.html").unlink()
    assert hfc.report(tmp_path / "run") == tmp_path / "run" / "report.html"
    assert (tmp_path / "run" / "report.html").exists()
    with pytest.raises(hfc.UserError, match=r"leave path out, .* as .*run/report\.html$"):
        hfc.report(tmp_path / "run", "b.html")
    with pytest.raises(hfc.UserError, match="this is a design"):
        hfc.report("pd-only", each=True)
    with pytest.raises(hfc.UserError, match="no such design"):
        hfc.report(str(tmp_path / "nowhere"))


PAPER = {"figures": "pdf", "width": "88mm", "latex": True}


@pytest.mark.slow
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
        ({"width": "88mm"}, "width: is that of figures"),
        ({"figures": "png"}, "figures = 'png': has to be one of pdf, svg, pgf"),
        ({"figures": "pdf", "width": 88}, "width = 88: has to be a text"),
    ]:
        with pytest.raises(hfc.UserError, match=why):
            hfc.report("pd-only", tmp_path / "c.html", scenario=short, **wrong)


def test_several_are_drawn_over_one_another(tmp_path):
    short = hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})
    two = {name: hfc.evaluate(name, short) for name in ("pd-only", "lin-lee-1999-table-1")}
    figure = hfc.plot(two, tmp_path / "a.pdf", "on a ramp", width="88mm")
    assert figure.get_figwidth() == pytest.approx(88 / 25.4)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [*two, "reference"]
    error = figure.axes[1].lines[0].get_ydata()
    assert max(abs(error)) == pytest.approx(1e3 * two["pd-only"].metrics["max_error_rad"])
    other = hfc.evaluate(
        "pd-only", hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.2})
    )
    with pytest.raises(hfc.UserError, match="of the same motion"):
        hfc.plot({"a": two["pd-only"], "b": other})
    with pytest.raises(hfc.UserError, match="all evaluations, results or findings"):
        hfc.plot({"a": "pd-only"})


def test_findings_are_drawn_as_their_searches(tmp_path):
    batch_folder(tmp_path, [({"search.preset": name}, [k, 9.0]) for k, name in enumerate("ab", 2)])
    found = hfc.findings(tmp_path)
    figure = hfc.plot(found)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["1: preset b", "2: preset a"]
    assert figure.axes[0].lines[1].get_ydata()[-1] == 5.5  # the median of 2 and 9
    twice = hfc.plot({"mine": found, "yours": found})
    assert len(twice.axes[0].lines) == 4
    assert twice.legends[0].get_texts()[0].get_text() == "mine 1: preset b"
