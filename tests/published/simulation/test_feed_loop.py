"""X-Y machines in the population simulator: the published figures, contour fitness, bad input."""

import csv

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.simulation.evaluating import evaluate


def test_trajectory_csv_names_axes_and_units(tmp_path):
    path = tmp_path / "motion.csv"
    arguments = ["simulate", "jee-koren-2004-aflc", "--set", "simulation.duration_s=4.0"]
    result = CliRunner().invoke(main, [*arguments, "--csv", str(path)])
    assert result.exit_code == 0, result.output
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert len(rows) == 400
    for axis in "xy":
        error = float(rows[3][f"{axis}_reference_BLU"]) - float(rows[3][f"{axis}_position_BLU"])
        assert float(rows[3][f"{axis}_error_BLU"]) == pytest.approx(error)
    assert "contour_error_BLU" in rows[0]


def test_a_hierarchy_can_be_searched_for_a_feed_drive(tmp_path, no_baselines):
    # As in test_judge.py, so that both have the same compiled programs.
    alike = ["--set", "simulation.duration_s=3.0", "--set", "search.stick_penalty=300"]
    sizes = ["--population", "24", "--generations", "2", *alike]
    folder = tmp_path / "run"
    result = CliRunner().invoke(
        main, ["design", "feed-drive-hierarchy", *sizes, "--out", str(folder), "--quiet"]
    )
    assert result.exit_code == 0, result.output
    found = load_design(str(folder))
    assert set(found.plant.axes) == {"x", "y"}
    assert found.plant.axes["y"]["positive_start"] == 7.23
    assert evaluate(found, own_scenario(found, str(folder))).fitness == found.score["fitness"]
    page = (folder / "report.html").read_text()
    assert "unit s/BLU" in page  # of the derivative gain
    assert "V/rad" not in page
