"""What functions of the API return is drawn by plot, and shows itself."""

from itertools import pairwise

import pytest

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


def test_usable_shows_itself():
    found = FOUND["usable"]()
    assert repr(found).startswith("Usable(yes=")
    assert found.answer.partition(":")[0] in ("yes", "no")
    assert f"machines={len(found.good)}" in repr(found)
    assert found._repr_html_().count("<tr>") == 7  # six figures, one motion
    with pytest.raises(hfc.UserError):
        hfc.usable("pd-only", "feed-drive-line")


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
