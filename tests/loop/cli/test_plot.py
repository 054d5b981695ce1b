"""hfc plot DESIGN WHAT: what is drawn against what hfc explain says, and what is refused."""

import json

import numpy as np
import pytest
from run_folders import ran
from surfaces_drawn import around_soc, drawn
from wording import refused_command

from hfc_design import api as hfc
from hfc_design.report.designs import picture


@pytest.mark.parametrize(
    ("name", "axis", "change"),
    [
        ("jee-koren-2004-flc", [], "error_change"),
        ("lin-gai-2009-fuzzy-sliding", ["x"], "error_rate"),
    ],
)
def test_a_surface_is_what_explain_says(name, axis, change, monkeypatch):
    x, y, values, *_ = drawn(monkeypatch, name, *([None, *axis] if axis else []))
    options = [text for one in axis for text in ("--axis", one)]
    for i, j in ((0, 0), (13, 70), (60, 33)):
        at = f"error={float(y[i])!r},{change}={float(x[j])!r}"
        told = json.loads(ran("explain", name, *options, "--at", at, "--json"))
        assert values[i, j] == pytest.approx(told["units"][0]["output"], abs=1e-12)


def test_what_is_inside_is_drawn_and_explained(monkeypatch, tmp_path):
    """Rules i - j over e = 20 E and ce = 60 CE sets: they say 20 E - 60 CE, of y twice that."""
    path = tmp_path / "around.json"
    path.write_text(json.dumps(around_soc(x=1.0, y=2.0)))
    assert refused_command("plot", path, "surface", "--out", tmp_path / "a.png").where == "--axis"
    record = hfc.load_design(path).controller.inner.axes["y"]
    x, y, values, labels, title, said = drawn(monkeypatch, path, None, "y")
    assert (labels, said) == (("change of error in a sample [µm]", "error [µm]"), "rules [1]")
    assert title == "rules"
    expected = 2e-3 * (record.law_gains().ge * y[:, None] - record.law_gains().gc * x)
    np.testing.assert_allclose(values, expected, atol=1e-12)
    at = ("--at", "error=0.1,error_change=0.01", "--axis", "y", "--json")
    told = json.loads(ran("explain", path, *at))
    by_hand = 2.0 * (0.1 * record.law_gains().ge - 0.01 * record.law_gains().gc)
    assert told["units"][0]["output"] == pytest.approx(by_hand)
    assert told["parts"] == pytest.approx({"rules": record.law_gains().gu * by_hand})
    assert told["inside"] == "cross-coupled"
    text = ran("explain", path, *at[:-1])
    assert "what cross-coupled adds depends on the whole" in text


def test_a_surface_in_space_has_the_same_values_and_labels():
    """The published table commands 32 units at most, and is drawn up to 1.25 times 21 BLU."""
    axes = picture(hfc.load_design("jee-koren-2004-flc"), "surface-3d").axes[0]
    assert axes.get_xlabel() == "change of error [BLU per sample]"
    assert (axes.get_ylabel(), axes.get_zlabel()) == ("error [BLU]", "command [unit]")
    assert axes.xy_dataLim.intervaly == pytest.approx([-26.25, 26.25])
    assert axes.zz_dataLim.intervalx == pytest.approx([-32.0, 32.0])
