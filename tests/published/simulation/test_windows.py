"""Metrics over parts of the motion, against the recorded motion; changed designs."""

from click.testing import CliRunner

from hfc_design.cli import main


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_a_report_says_what_a_window_is(tmp_path):
    windows = 'windows=[{name="late", from_s=0.05}]'
    small = ("--set", "simulation.duration_s=0.1", "--population", 16, "--generations", 2)
    out = tmp_path / "run"
    assert (
        hfc("design", "c-axis-ramp", "--out", out, *small, "--set", windows, "--quiet").exit_code
        == 0
    )
    page = (out / "report.html").read_text()
    assert "late: largest tracking error [rad]" in page
