"""The command line as a user meets it."""

import csv
import io
import json
import signal
import subprocess
import sys
from contextlib import suppress

import numpy as np
import pytest
from run_folders import hfc
from wording import refused_command

from hfc_design.cli import search_progress
from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario

SHORT = ["--set", "simulation.duration_s=0.1"]
SMALL = ["--population", "4", "--generations", "3", "--set", "controller.kind=pd", *SHORT]


def test_score_of_the_published_design_is_the_published_one():
    done = hfc("score", "lin-lee-1999-table-1", "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["fitness"] == pytest.approx(380.5715, abs=5e-5)
    assert found["scenario"] == "c-axis-ramp"
    assert found["stick_events"] == 0


def test_scores_with_a_change_on_another_scenario_and_as_a_table():
    found = []
    inertia = ("--set", "plant.parameters.spindle_inertia=8")
    for more in ((), inertia, ("--scenario", "c-axis-sine")):
        done = hfc("score", "pd-only", "--json", *SHORT, *more)
        found.append(json.loads(done.stdout)["fitness"])
    assert len({*found}) == 3
    table = hfc("score", "pd-only", *SHORT).stdout
    for part in ("c-axis-ramp", f"{found[0]:.6g}", "rms_error_rad", "peak_voltage_V"):
        assert part in table


def test_diverged_design_is_a_result(tmp_path):
    path = tmp_path / "wild.json"
    path.write_text(design_json(load_design("pd-only", {"controller.pd.kd": 1e9})))
    done = hfc("score", path, "--json", *SHORT)
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["diverged"] is True
    assert found["fitness"] is None
    assert found["merit"] is None
    assert found["rms_error_rad"] is None
    assert "diverged" in hfc("score", path, *SHORT).stdout


def test_a_motion_is_written_with_the_agreed_header_and_a_row_a_sample(tmp_path):
    short = ("simulate", "pd-only", *SHORT)
    done = hfc(*short, "--csv", tmp_path / "a.csv", "--plot", tmp_path / "a.png")
    assert done.exit_code == 0
    assert done.stdout.split() == [str(tmp_path / "a.csv"), str(tmp_path / "a.png")]
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.reader(io.StringIO(hfc(*short).stdout)))
    assert rows == list(csv.reader((tmp_path / "a.csv").read_text().splitlines()))
    assert ",".join(rows[0]) == (
        "time_s,reference_rad,spindle_angle_rad,error_rad,spindle_velocity_rad_s,"
        "deflection_rad,voltage_V,load_torque_Nm"
    )
    data = np.array(rows[1:], float)
    assert data.shape == (100, 8)
    assert np.allclose(data[:, 1] - data[:, 2], data[:, 3], atol=1e-15)
    assert np.allclose(data[:, 0], np.arange(100) * 0.001)


def _interrupted(self, search):
    raise KeyboardInterrupt


def test_interrupted_design_says_how_to_go_on(tmp_path, monkeypatch):
    monkeypatch.setattr(search_progress.Watch, "generation", _interrupted)
    done = hfc("design", "c-axis-ramp", *SMALL, "--out", tmp_path / "run")
    assert done.exit_code == 1
    assert f"hfc design --resume --out {tmp_path / 'run'}" in done.stderr
    assert (tmp_path / "run" / "checkpoint.npz").exists()
    for command in ("score", "simulate", "export --to c"):
        refused = refused_command(*command.split(), tmp_path / "run")
        assert refused.where == str(tmp_path / "run")


def test_an_interrupt_that_a_library_has_ignored_is_heard_after_the_generation(
    tmp_path, monkeypatch
):
    def ignored(self, search):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(search_progress.Watch, "generation", ignored)
    done = hfc("design", "c-axis-ramp", *SMALL, "--out", tmp_path / "run")
    assert done.exit_code == 1
    assert "interrupted" in done.stderr
    assert len((tmp_path / "run" / "history.csv").read_text().splitlines()) == 3


def test_an_interrupt_that_nobody_could_hear_is_not_told_as_a_fault():
    """As in what a garbage collector calls; other faults there are told."""
    code = """
from hfc_design.core.interrupt import listen
class Gone:
    def __init__(self, fault): self.fault = fault
    def __del__(self): raise self.fault
listen()
Gone(KeyboardInterrupt())
Gone(ValueError("told"))
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "KeyboardInterrupt" not in ended.stderr
    assert "ValueError: told" in ended.stderr


def test_export_csv_of_a_fuzzy_controller(tmp_path):
    path = tmp_path / "tables"
    assert hfc("export", "jee-koren-2004-flc", "--to", "csv", "--out", path).exit_code == 0
    tables = {file.name: list(csv.reader(file.read_text().splitlines())) for file in path.iterdir()}
    rules = tables["rules.csv"]
    assert (
        rules[0][1:] == [row[0] for row in rules[1:]] == ["NL", "NM", "NS", "ZR", "PS", "PM", "PL"]
    )
    assert rules[6] == ["PM", "8.0", "8.0", "8.0", "16.0", "16.0", "32.0", "32.0"]  # JK04 table 1
    assert tables["error_terms.csv"][1] == ["NL", "", "-21.0", "-16.0"]  # JK04 table 3
    assert tables["error_change_terms.csv"][5] == ["PS", "0.5", "1.5", "2.5"]
    assert tables["manifest.csv"][1][-1] == "rules.csv"


def test_a_file_of_a_kind_whose_defaults_are_computed(tmp_path):
    file = tmp_path / "mine.toml"
    kind = ("--plant", "positioning-stage", "--controller", "fuzzy-sliding")
    assert hfc("init", *kind, "--out", file).exit_code == 0
    assert load_scenario(str(file)).controller.kind == "fuzzy-sliding"
