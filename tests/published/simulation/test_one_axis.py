"""A feed drive of one axis: columns, metrics, pictures in its own units; whole commanded BLU."""

from one_axis import SCENARIO, printed

from hfc_design.report.parts import BASELINES, Baseline


def test_a_run_designs_for_one_axis_and_reports_in_its_units(tmp_path, monkeypatch):
    scenario = tmp_path / "one-axis.toml"
    scenario.write_text(SCENARIO)
    rival = {"jee-koren-2004-pid": Baseline("JK04 PID")}  # the others take long to compile
    monkeypatch.setitem(BASELINES, "feed-drive", rival)
    folder = tmp_path / "run"
    sizes = ["--population", "24", "--generations", "2"]
    printed("design", scenario, *sizes, "--out", folder, "--quiet")
    page = (folder / "report.html").read_text()
    assert "largest command [unit]" in page
    assert "jee-koren-2004-pid" in page
    assert "voltage" not in page
    assert "rad]" not in page
    text = printed("simulate", folder, "--plot", tmp_path / "a.png")
    assert text.split() == [str(tmp_path / "a.png")]
