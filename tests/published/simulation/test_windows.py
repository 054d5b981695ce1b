"""Metrics over parts of the motion, against the recorded motion; changed designs."""

from run_folders import hfc


def test_a_report_says_what_a_window_is(tmp_path, known_use):
    windows = 'windows=[{name="late", from_s=0.05}]'
    small = ("--set", "simulation.duration_s=0.1", "--population", 16, "--generations", 2)
    out = tmp_path / "run"
    asked = ("--out", out, *small, "--set", windows, "--quiet")
    assert hfc("design", "c-axis-ramp", *asked).exit_code == 0
    page = (out / "report.html").read_text()
    assert "late: largest tracking error [rad]" in page
