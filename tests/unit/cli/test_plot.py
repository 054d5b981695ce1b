"""``hfc plot``: what is drawn against what ``hfc explain`` says, and over one another."""

import json

import numpy as np
import pytest
from run_folders import ran, searched
from surfaces_drawn import drawn
from wording import refused

from hfc_design import api as hfc
from hfc_design.batch.findings import convergence
from hfc_design.report.designs import picture
from hfc_design.runtime import Controller

TABLE_1 = "lin-lee-1999-table-1"


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


def test_searches_of_runs_have_distinct_names(tmp_path):
    folders = [searched(tmp_path / name, k + 1.0) for k, name in enumerate(("a/b", "x/b", "x/c"))]
    axes = convergence(folders).axes[0]
    assert axes.get_ylabel() == "best fitness so far"
    labels = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert labels == ["a/b", "x/b", "c"]
    for k, line in enumerate(axes.lines):  # three generations, a third more each
        assert line.get_ydata() == pytest.approx(np.arange(1, 4) * (k + 1) / 3)
    searched(tmp_path / "d", 4.0, "loss")
    axes = convergence([*folders, tmp_path / "d"]).axes[0]
    assert axes.get_ylabel() == "best merit (definitions differ) so far"


def test_no_history_and_too_many_curves(tmp_path):
    for k in range(11):
        searched(tmp_path / f"r{k}", k + 1.0)
    with refused():
        convergence(sorted(tmp_path.iterdir()))
    (tmp_path / "r0" / "history.csv").unlink()
    with refused():
        convergence([tmp_path / "r0"])
    with refused():
        convergence([tmp_path / "r1", tmp_path / "r1"])
