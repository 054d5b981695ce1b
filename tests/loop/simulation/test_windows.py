"""Metrics over parts of the motion, against the recorded motion; changed designs."""

import io
import json

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.pairing import load_design


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def printed(*arguments):
    found = hfc(*arguments)
    assert found.exit_code == 0, found.output
    return found.stdout


def recorded(*arguments):
    """Columns of the trajectory that hfc simulate writes."""
    text = printed("simulate", *arguments)
    names = text.partition("\n")[0].split(",")
    return dict(zip(names, np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1).T, strict=True))


def test_windows_of_an_axis():
    windows = 'windows=[{name="early", to_s=1.0}, {name="late", from_s=8.0}]'
    found = json.loads(printed("score", "pd-only", "--json", "--set", windows))
    motion = recorded("pd-only")
    for name, part in (("early", motion["time_s"] < 1.0), ("late", motion["time_s"] >= 8.0)):
        error = motion["error_rad"][part]
        assert found[f"{name}_rms_error_rad"] == pytest.approx(np.sqrt(np.mean(error**2)))
        assert found[f"{name}_max_error_rad"] == np.abs(error).max()
        assert found[f"{name}_iae_rad_s"] == pytest.approx(np.abs(error).sum() * 1e-3)
        assert found[f"{name}_final_error_rad"] == error[-1]
    assert found["late_rms_error_rad"] != found["rms_error_rad"]


def test_windows_of_a_path():
    own = ("jee-koren-2004-flc", "--set", "simulation.duration_s=8")
    windows = 'windows=[{name="begin", to_s=2.0}, {name="middle", from_s=3.0, to_s=7.0}]'
    found = json.loads(printed("score", *own, "--json", "--set", windows))
    motion = recorded(*own)
    time = motion["time_s"]
    for name, part in (("begin", time < 2.0), ("middle", (time >= 3.0) & (time < 7.0))):
        off, change = motion["contour_error_BLU"][part], 0.0
        for axis in "xy":
            error, command = motion[f"{axis}_error_BLU"][part], motion[f"{axis}_command_unit"][part]
            assert found[f"{name}_{axis}_max_error_BLU"] == np.abs(error).max()
            change = max(change, np.sqrt(np.mean(np.diff(command) ** 2)))
        assert found[f"{name}_rms_contour_error_BLU"] == pytest.approx(np.sqrt(np.mean(off**2)))
        assert found[f"{name}_rms_command_change_unit"] == pytest.approx(change)
    # X reverses at the start only (t = 0), Y after a quarter of 20 s: in the middle
    assert found["begin_worst_glitch_BLU"] is None
    assert found["middle_worst_glitch_BLU"] is not None


def test_a_change_does_what_the_same_value_in_the_file_does(tmp_path):
    path = tmp_path / "mine.json"
    printed("export", "jee-koren-2004-flc", "--to", "json", "--out", path)
    data = json.loads(path.read_text())
    data["controller"]["integral_gain"] = 8.0
    path.write_text(json.dumps(data))
    own = ("--json", "--set", "simulation.duration_s=2")
    by_hand = json.loads(printed("score", path, *own))
    changed = json.loads(
        printed("score", "jee-koren-2004-flc", "--change", "controller.integral_gain=8", *own)
    )
    assert changed == by_hand
    assert changed != json.loads(printed("score", "jee-koren-2004-flc", *own))


def test_a_changed_design_says_so_and_loses_its_score():
    design = load_design("jee-koren-2004-aflc", {"controller.adaptation.k_c": 0.25})
    assert design.controller.adaptation.k_c == 0.25
    assert design.controller.adaptation.k_a == 0.5
    assert design.provenance["changes"] == {"controller.adaptation.k_c": 0.25}
    assert design.score == {}
