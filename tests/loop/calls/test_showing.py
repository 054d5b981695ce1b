"""What functions of the API return is drawn by plot, and shows itself."""

import re

import made_up
import pytest
from wording import refused

import hfc_design.api as hfc
from hfc_design.files.design import Design

SHORT = {"simulation.duration_s": 0.1}


@pytest.fixture(scope="module")
def ramp():
    return hfc.load_scenario("c-axis-ramp", SHORT)


@pytest.fixture(scope="module")
def found(ramp):
    return hfc.evaluate("pd-only", ramp)


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
    data = made_up.linear("lqi", 5, "feed-drive").model_dump(mode="json")
    own = {"kind": "pid+ff", "sample_time_s": 0.01, "kp": 1.2}
    loop = Design.model_validate(data | {"controller": own})
    found = hfc.stability(loop)
    own = found.numbers()
    sizes = [one["slowest_pole"] for one in own["points"] if "why" not in one]
    assert own["stable"] == (max(sizes) < 1.0) is True
    assert re.match(r"LoopMargins\(stable=True, sensitivity=", repr(found))
    assert f"{own['worst']['phase_margin_deg']['value']:.4g}" in found._repr_html_()
    with refused():
        hfc.stability(loop, gain=2.0)


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
