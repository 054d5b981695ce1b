"""hfc plot DESIGN WHAT: what is drawn against what hfc explain says, and what is refused."""

import json

import numpy as np
import pytest
from run_folders import batch_folder, ran
from surfaces_drawn import around_soc, drawn
from wording import refused_command

from hfc_design import api as hfc
from hfc_design.report.designs import picture
from hfc_design.runtime import Controller

TABLE_1 = "lin-lee-1999-table-1"


@pytest.mark.parametrize(
    ("what", "suffix"),
    [("surface-3d", "png"), ("terms", "svg"), ("tables", "pdf"), ("tree", "png")],
)
def test_a_file_of_each(tmp_path, what, suffix):
    path = tmp_path / f"a.{suffix}"
    assert ran("plot", TABLE_1, what, "--out", path) == f"{path}\n"
    start = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]
    assert path.read_bytes().startswith(start)


def test_names_and_units_stand_in_the_picture(tmp_path):
    path = tmp_path / "a.svg"
    ran("plot", TABLE_1, "surface", "--unit", "unit-7", "--out", path)
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
        told = json.loads(ran("explain", TABLE_1, "--at", at, "--json"))
        said = next(u["output"] for u in told["units"] if u["unit"] == "unit-7")
        assert values[i, j] == pytest.approx(said, abs=1e-12)


def test_axes_that_have_the_same_inside_need_no_name(monkeypatch, tmp_path):
    path = tmp_path / "around.json"
    path.write_text(json.dumps(around_soc(all=1.0)))
    found = [drawn(monkeypatch, path, None, axis)[2] for axis in ("", "x", "y")]
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
    z = ("--axis", "z", "--out", tmp_path / "a.png")
    assert refused_command("plot", path, "surface", *z).where == "--axis 'z'"


def test_a_table_that_has_learnt_nothing_says_so():
    for what in ("surface", "tables"):
        figure = picture(hfc.load_design("huang-soc"), what)
        assert figure.axes[0].get_title() == "rules at the start: it has learned none"


def test_a_network_is_drawn_as_the_runtime_commands(monkeypatch):
    """From an error of 0 on the change is the error: both are counted in 2 um by huang-neural."""
    x, y, values, labels, _, said = drawn(monkeypatch, "huang-neural")
    assert (labels[0], said) == ("error [µm]", "command [V]")
    np.testing.assert_array_equal(x, y)
    design = hfc.load_design("huang-neural")
    limit = design.limits.command
    for k in (0, 30, 41, 80):
        controller = Controller(design)
        controller.step({"error": 0.0})
        command = controller.step({"error": 1e-3 * float(x[k])})
        assert command == pytest.approx(np.clip(values[k, k], -limit, limit), rel=1e-9)


def test_terms_are_the_papers():
    """LL eq. 3b: f2 is 1 from -0.65 to -0.55 and exp(-8 0.45^2) at -0.1."""
    line = picture(hfc.load_design(TABLE_1), "terms").axes[0].lines[1]
    at = dict(zip(np.round(line.get_xdata(), 9), line.get_ydata(), strict=True))
    xs = np.array([*at])
    found = np.interp([-0.6, -0.1], xs, [*at.values()])
    assert found == pytest.approx([1.0, np.exp(-8 * 0.45**2)], abs=1e-4)


@pytest.mark.parametrize("command", [("plot", "surface", "--out"), ("simulate", "", "--csv")])
def test_the_folder_of_a_batch_is_called_one(command, tmp_path):
    batch_folder(tmp_path / "many", [({"search.preset": "race"}, [1.0])])
    name, what, option = command
    words = [name, tmp_path / "many", *filter(None, [what]), option, tmp_path / "a.png"]
    assert refused_command(*words).where == str(tmp_path / "many")
