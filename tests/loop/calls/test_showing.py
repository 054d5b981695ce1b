"""What functions of the API return is drawn by plot, and shows itself."""

from itertools import pairwise

import pytest
from wording import refused

import hfc_design.api as hfc

SHORT = {"simulation.duration_s": 0.1}


@pytest.fixture(scope="module")
def ramp():
    return hfc.load_scenario("c-axis-ramp", SHORT)


@pytest.fixture(scope="module")
def found(ramp):
    return hfc.evaluate("pd-only", ramp)


@pytest.fixture(scope="module")
def usable(ramp):
    return hfc.usable("pd-only", ramp, machines=4)


def test_on_many_machines_in_a_column_every_text_is_whole_and_no_numbers_touch(ramp, usable):
    spread = hfc.robustness("pd-only", ramp, 0.1, 4)
    titles = {"rms error [mrad]": spread, "error once settled\n[mrad]": usable}
    for title, shown in titles.items():
        figure = hfc.plot(shown, width="88mm")
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


def test_a_large_picture_is_drawn_in_points():
    bundle, about = hfc.picture("jee-koren-2004-flc", "surface")._repr_mimebundle_()
    assert set(bundle) <= {"image/png", "image/svg+xml", "text/plain"}
    if "image/png" in bundle:
        assert about["image/png"]["width"] == 540  # of 5.4 in


def test_a_title_stands_above(found):
    figure = hfc.plot(found, title="on a ramp & more")
    assert "on a ramp &amp; more" in figure._repr_mimebundle_()[0].get("image/svg+xml")


def test_what_was_not_searched_has_no_search_to_draw(found):
    for thing in (hfc.Result(hfc.load_design("pd-only"), found, None), "pd-only"):
        with refused():
            hfc.plot(thing)


def test_the_range_of_the_published_drive():
    """Jee & Koren 2004, fig. 4, cut off at the linear limit; tables of the design within it."""
    found = hfc.stability("jee-koren-2004-flc")
    assert found.numbers()["k1_bound"] == pytest.approx(7.28786, rel=1e-5)
    assert found.range == hfc.stability(gain=28.3, time_constant=0.055).range
    assert found.points
    assert "7.28786" in found._repr_html_()
    assert repr(found).startswith("StableGains(k1_bound=7.288, ")


def test_usable_shows_itself(usable):
    assert repr(usable).startswith("Usable(yes=")
    assert usable.answer.partition(":")[0] in ("yes", "no")
    assert f"machines={len(usable.good)}" in repr(usable)
    assert usable._repr_html_().count("<tr>") == 7  # six figures, one motion
    with refused():
        hfc.usable("pd-only", "feed-drive-line")


def test_several_are_drawn_over_one_another(found, ramp, tmp_path):
    soft = hfc.load_design("pd-only", {"name": "soft", "controller.pd.kp": 900.0})
    two = {"pd-only": found, "soft": hfc.evaluate(soft, ramp)}
    figure = hfc.plot(two, tmp_path / "a.pdf", "on a ramp", width="88mm")
    assert figure.get_figwidth() == pytest.approx(88 / 25.4)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [*two, "reference"]
    error = figure.axes[1].lines[0].get_ydata()
    assert max(abs(error)) == pytest.approx(1e3 * found.metrics["max_error_rad"])
    longer = hfc.load_scenario(ramp, {"simulation.duration_s": 0.2})
    for other in ({"b": hfc.evaluate("pd-only", longer)}, {"b": "pd-only"}):
        with refused():
            hfc.plot({"a": found} | other)
