"""hfc plot DESIGN WHAT: what is drawn against what hfc explain says, and what is refused."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design import api as hfc
from hfc_design.cli import main
from hfc_design.controllers import surfaces
from hfc_design.report.designs import picture

TABLE_1 = "lin-lee-1999-table-1"


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


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
@pytest.mark.parametrize("what", ["surface", "surface-3d", "terms", "tables", "tree"])
def test_a_file_of_each(tmp_path, what, suffix):
    path = tmp_path / f"a.{suffix}"
    assert printed("plot", TABLE_1, what, "--out", path) == f"{path}\n"
    start = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]
    assert path.read_bytes().startswith(start)


def test_names_and_units_stand_in_the_picture(tmp_path):
    path = tmp_path / "a.svg"
    printed("plot", TABLE_1, "surface", "--unit", "unit-7", "--out", path)
    text = path.read_text()
    assert "previous spindle velocity [mrad/s]" in text
    assert "spindle velocity [mrad/s]" in text
    assert "output [1]" in text


def test_a_surface_is_what_explain_says(monkeypatch):
    """Unit 7 of Table I reads two readings of the spindle."""
    x, y, values, _, _, _ = drawn(monkeypatch, TABLE_1, "unit-7")
    unit = next(u for u in hfc.load_design(TABLE_1).controller.units if u.id == 7)
    for i, j in ((0, 0), (13, 70), (40, 40), (80, 5)):
        readings = {unit.column_input: 1e-3 * x[j], unit.row_input: 1e-3 * y[i]}
        others = {"error": 0.0, "error_rate": 0.0, "deflection": 0.0, "deflection_rate": 0.0}
        at = ",".join(f"{name}={float(u)!r}" for name, u in (others | readings).items())
        told = json.loads(printed("explain", TABLE_1, "--at", at, "--json"))
        said = next(u["output"] for u in told["units"] if u["unit"] == "unit-7")
        assert values[i, j] == pytest.approx(said, abs=1e-12)


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


def test_terms_are_the_papers():
    """LL eq. 3b: f2 is 1 from -0.65 to -0.55 and exp(-8 0.45^2) at -0.1."""
    line = picture(hfc.load_design(TABLE_1), "terms").axes[0].lines[1]
    at = dict(zip(np.round(line.get_xdata(), 9), line.get_ydata(), strict=True))
    xs = np.array([*at])
    found = np.interp([-0.6, -0.1], xs, [*at.values()])
    assert found == pytest.approx([1.0, np.exp(-8 * 0.45**2)], abs=1e-4)


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
    assert not (tmp_path / "a.png").exists()
