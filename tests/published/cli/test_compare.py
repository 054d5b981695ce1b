"""``hfc compare`` as a user meets it."""

import csv
import json

import numpy as np
from places import ROOT
from run_folders import hfc

SHORT = ["--set", "simulation.duration_s=0.3", "--machines", "6"]
PARAMETERS = "backlash", "table_mass"
TWO = ["lin-lee-1999-table-1", "pd-only"]
PIDS = ["huang-pid", ROOT / "experiments/designed_contours/table-expert-pid.json"]


def test_tables_mark_the_best_and_say_what_was_drawn(tmp_path):
    found = hfc("compare", *TWO, *SHORT, "--spread", "0.1", "--seed", "4")
    assert found.exit_code == 0, found.output
    assert "c-axis-ramp, 6 machines within +-10 %" in found.stdout
    lines = found.stdout.splitlines()
    stable = next(line for line in lines if line.startswith("stable machines [%]"))
    assert stable.split() == ["stable", "machines", "[%]", "all", "100", "100"]
    peak = next(line for line in lines if line.startswith("peak voltage [V]"))
    *_, volts, mark = peak.split()
    assert 743.01 * 0.02 < float(volts) < 15.5  # kd times the rate at the start, and a little more
    assert mark == "*"
    assert "c-axis-ramp, rms error: lin-lee-1999-table-1 over" in found.stdout
    assert "simulated in" in found.stderr


def test_single_parameters_have_a_tolerance_of_their_own(tmp_path):
    table = tmp_path / "machines.csv"
    single = ["--spread", "0.01", "--tolerance", "backlash=0.5"]
    few = ["--set", "simulation.duration_s=0.3", "--machines", "20"]
    found = hfc("compare", *PIDS, *few, *single, "--csv", table)
    assert found.exit_code == 0, found.output
    assert "20 machines within +-1 %, backlash +-50 %" in " ".join(found.stdout.split())
    with table.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["design"] == "huang-pid"]
    backlash, mass = (np.array([float(row[f"x_{name}"]) for row in rows]) for name in PARAMETERS)
    assert (backlash[0], mass[0]) == (0.4, 100.0)
    assert 0.2 <= backlash.min() < 0.25
    assert 0.55 < backlash.max() <= 0.6
    assert 99.0 <= mass.min() < mass.max() <= 101.0
    for told in ("backlash=2", "backlash=x", "gap=0.5"):
        found = hfc("compare", *PIDS, *few, "--tolerance", told)
        assert (found.exit_code, told.split("=")[0] in found.stderr) == (2, True)


def test_a_folder_of_page_table_and_numbers(tmp_path):
    out = tmp_path / "beside"
    scenarios = ["--scenario", "c-axis-ramp", "--scenario", "c-axis-step"]
    found = hfc("compare", *TWO, *scenarios, *SHORT, "--out", out, "--json")
    assert found.exit_code == 0, found.output
    numbers = json.loads(found.stdout)
    assert list(numbers["motions"]) == ["c-axis-ramp", "c-axis-step", "every motion"]
    assert json.loads((out / "comparison.json").read_text()) == numbers
    with (out / "comparison.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 2 * 7
    mine = [row for row in rows if (row["design"], row["motion"]) == (TWO[0], "c-axis-step")]
    # What is not stable ranks behind all others.
    errors = sorted(
        float(row["rms_error_rad"]) if row["stable"] == "1" else float("inf") for row in mine[1:]
    )
    told = numbers["motions"]["c-axis-step"]["designs"][TWO[0]]
    assert told["metrics"]["rms_error_rad"]["median"] == errors[2]
    assert told["metrics"]["rms_error_rad"]["nominal"] == float(mine[0]["rms_error_rad"])
    page = (out / "report.html").read_text()
    again = "hfc compare lin-lee-1999-table-1 pd-only --scenario c-axis-ramp --scenario c-axis-step"
    assert again in page
    again = hfc("compare", *TWO, *SHORT, "--out", out)
    assert (again.exit_code, "already exists" in again.stderr) == (2, True)


def test_single_files_and_own_scenario_of_the_first(tmp_path):
    html, table = tmp_path / "page.html", tmp_path / "x.csv"
    arguments = ["lin-lee-1999-table-2", "pd-only", *SHORT, "--html", html, "--csv", table]
    found = hfc("compare", *arguments)
    assert found.exit_code == 0, found.output
    assert found.stdout.splitlines()[-2:] == [str(html), str(table)]
    assert "c-axis-ramp-cutting" in html.read_text()
    assert table.read_text().count("\n") == 1 + 2 * 7
