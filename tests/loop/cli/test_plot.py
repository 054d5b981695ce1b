"""hfc plot DESIGN WHAT: what is drawn against what hfc explain says, and what is refused."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design import api as hfc
from hfc_design.cli import main
from hfc_design.controllers import surfaces
from hfc_design.files.design import design_json
from hfc_design.report.designs import picture

TABLE_1 = "lin-lee-1999-table-1"
SHORT = ("--set", "simulation.duration_s=0.2")


def printed(*arguments):
    done = CliRunner().invoke(main, [*map(str, arguments)])
    assert done.exit_code == 0, done.output
    return done.stdout


def refused(*arguments):
    done = CliRunner().invoke(main, [*map(str, arguments)])
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    return done.stderr


def drawn(monkeypatch, *asked):
    """What a picture of a surface is made of: column, row, values, labels."""
    found = []
    monkeypatch.setattr(surfaces.units, "surface", lambda *told: found.append(told))
    picture(hfc.load_design(asked[0]), "surface", *asked[1:])
    return found[0]


@pytest.mark.parametrize(
    "asked", [(TABLE_1, "tree"), ("pd-only", TABLE_1, "motion", *SHORT)], ids=["tree", "motion"]
)
def test_a_picture_is_as_wide_as_a_column(asked, tmp_path):
    path = tmp_path / "a.svg"
    printed("plot", *asked, "--width", "88mm", "--out", path)
    width = float(re.search(r'<svg [^>]*width="([\d.]+)pt"', path.read_text())[1])
    assert width == pytest.approx(88.0 / 25.4 * 72.0, abs=0.01)
    told = refused("plot", *asked, "--width", "5mm", "--out", tmp_path / "b.svg")
    assert told.startswith("hfc: --width: '5mm': has to be a number with a unit")
    assert not (tmp_path / "b.svg").exists()


def test_a_surface_of_a_feed_drive_is_what_explain_says(monkeypatch):
    x, y, values, *_ = drawn(monkeypatch, "jee-koren-2004-flc")
    for i, j in ((0, 0), (13, 70), (60, 33)):
        at = f"error={float(y[i])!r},error_change={float(x[j])!r}"
        told = json.loads(printed("explain", "jee-koren-2004-flc", "--at", at, "--json"))
        assert values[i, j] == pytest.approx(told["units"][0]["output"], abs=1e-12)


def test_a_surface_of_sliding_control_is_what_explain_says(monkeypatch):
    name = "lin-gai-2009-fuzzy-sliding"
    x, y, values, *_ = drawn(monkeypatch, name, None, "x")
    for i, j in ((0, 0), (13, 70), (60, 33)):
        at = f"error={float(y[i])!r},error_rate={float(x[j])!r}"
        told = json.loads(printed("explain", name, "--axis", "x", "--at", at, "--json"))
        assert values[i, j] == pytest.approx(told["units"][0]["output"], abs=1e-12)


def around_soc(**axes):
    """Cross-coupled control around self-organising controllers, whose tables differ by axis."""
    record, own = (
        json.loads(design_json(hfc.load_design(name)))
        for name in ("huang-cross-coupled", "huang-soc")
    )
    table = np.subtract.outer(np.arange(11.0), np.arange(11.0))
    inner = {
        axis: own["controller"] | {"table": (size * table).tolist()} for axis, size in axes.items()
    }
    per_axis = {"kind": "per-axis", "axes": inner}
    record["controller"]["inner"] = per_axis if len(inner) > 1 else inner["all"]
    return record | {"name": "around"}


def test_what_is_inside_is_drawn_and_explained(monkeypatch, tmp_path):
    """Rules i - j over e = 20 E and ce = 60 CE sets: they say 20 E - 60 CE, of y twice that."""
    path = tmp_path / "around.json"
    path.write_text(json.dumps(around_soc(x=1.0, y=2.0)))
    assert "--axis: is missing, one has to be named; design around has x, y" in refused(
        "plot", path, "surface", "--out", tmp_path / "a.png"
    )
    record = hfc.load_design(path).controller.inner.axes["y"]
    x, y, values, labels, title, said = drawn(monkeypatch, path, None, "y")
    assert (labels, said) == (("change of error in a sample [µm]", "error [µm]"), "rules [1]")
    assert title == "rules"
    expected = 2e-3 * (record.gains().ge * y[:, None] - record.gains().gc * x)
    np.testing.assert_allclose(values, expected, atol=1e-12)
    at = ("--at", "error=0.1,error_change=0.01", "--axis", "y", "--json")
    told = json.loads(printed("explain", path, *at))
    by_hand = 2.0 * (0.1 * record.gains().ge - 0.01 * record.gains().gc)
    assert told["units"][0]["output"] == pytest.approx(by_hand)
    assert told["parts"] == pytest.approx({"rules": record.gains().gu * by_hand})
    assert told["inside"] == "cross-coupled"
    text = printed("explain", path, *at[:-1])
    assert "what cross-coupled adds depends on the whole machine" in text


def test_a_surface_in_space_has_the_same_values_and_labels():
    """The published table commands 32 units at most, and is drawn up to 1.25 times 21 BLU."""
    axes = picture(hfc.load_design("jee-koren-2004-flc"), "surface-3d").axes[0]
    assert axes.get_xlabel() == "change of error [BLU per sample]"
    assert (axes.get_ylabel(), axes.get_zlabel()) == ("error [BLU]", "command [unit]")
    assert axes.xy_dataLim.intervaly == pytest.approx([-26.25, 26.25])
    assert axes.zz_dataLim.intervalx == pytest.approx([-32.0, 32.0])


def test_what_a_kind_has_not(tmp_path):
    out = ("--out", tmp_path / "a.png")
    assert "has no picture 'tree'; it has surface, surface-3d, terms, tables" in refused(
        "plot", "jee-koren-2004-aflc", "tree", *out
    )
    assert "is of kind pd: it has no fuzzy units" in refused("plot", "pd-only", "terms", *out)
    assert "unit-7, unit-3, unit-1, unit-0" in refused(
        "plot", TABLE_1, "surface", "--unit", "unit-9", *out
    )
    assert "has x, y, z, a, c" in refused("plot", "lin-gai-2009-fuzzy-sliding", "surface", *out)
    assert "png, .svg or .pdf" in refused("plot", TABLE_1, "tree", "--out", tmp_path / "a.gif")
    loop = "emps-cascade is of kind pid+ff: it has no fuzzy units to draw; hfc stability --plot"
    assert loop in refused("plot", "emps-cascade", "surface", *out)
    assert "huang-cross-coupled-x is of kind pid" in refused(
        "plot", "huang-cross-coupled", "surface", *out
    )
    assert "huang-soc has no picture 'tree'; it has surface" in refused(
        "plot", "huang-soc", "tree", *out
    )
    assert "the same on every axis, leave --axis out" in refused(
        "plot", "huang-soc", "surface", "--axis", "x", *out
    )
    assert not (tmp_path / "a.png").exists()
