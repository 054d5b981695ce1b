"""One design on machines that differ: each against its own run, stability against its poles."""

import json

import numpy as np
import pytest
from one_by_one import alone, case
from run_folders import hfc

from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.monte_carlo import robustness


def test_quantiles_are_those_of_the_stable_machines():
    design, scenario = case("pd-only", seconds=0.5)
    found = robustness(design, scenario, 0.1, 11, seed=2)
    runs = [alone(design, scenario, found.machines, k).metrics for k in range(1, 12)]
    wanted = sorted(run["rms_error_rad"] for run in runs)
    numbers = found.numbers()["metrics"]["rms_error_rad"]
    assert numbers["count"] == 11
    # Of eleven sorted values the quantile q stands at place 10 q, between two of them if need be.
    assert numbers["q05"] == pytest.approx((wanted[0] + wanted[1]) / 2, rel=1e-9)
    assert numbers["q25"] == pytest.approx((wanted[2] + wanted[3]) / 2, rel=1e-9)
    assert numbers["q50"] == pytest.approx(wanted[5], rel=1e-9)
    kept = np.array([True] * 3 + [False] * 8)
    some = found._replace(stable=kept).numbers()
    assert some["stable_share"] == pytest.approx(3 / 11)
    middle = np.median([run["rms_error_rad"] for run in runs[:3]])
    assert some["metrics"]["rms_error_rad"]["q50"] == pytest.approx(middle, rel=1e-9)
    none = found._replace(stable=np.zeros(11, bool)).numbers()["metrics"]["rms_error_rad"]
    assert (none["q50"], none["count"]) == (None, 0)


SHORT = ["--set", "simulation.duration_s=0.5", "--spread", "0.2", "--samples", "11"]


def test_the_command_tells_the_same_as_json_table_and_picture(tmp_path):
    done = hfc("score", "pd-only", *SHORT, "--seed", 4, "--json", "--plot", tmp_path / "a.png")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert (found["samples"], found["seed"], found["stable_share"]) == (11, 4, 1.0)
    design, scenario = case("pd-only", seconds=0.5)
    own = {"design": "pd-only", "scenario": "c-axis-ramp", "judged_by": scenario.judge().title}
    assert found == own | robustness(design, scenario, 0.2, 11, seed=4).numbers()
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert done.stderr.startswith("11 machines in ")
    table = hfc("score", "pd-only", *SHORT, "--seed", 4)
    assert max(map(len, table.stdout.splitlines())) <= 80
    assert "100 % of 11 machines are stable, the nominal one too" in table.stdout
    row = next(line for line in table.stdout.splitlines() if "rms_error_rad" in line)
    assert row.split()[1] == f"{found['metrics']['rms_error_rad']['nominal']:.3g}"


def test_the_nominal_motion_is_kept_and_no_other():
    design, scenario = case("pd-only", seconds=0.5)
    found = robustness(design, scenario, 0.2, 11)
    wanted = evaluate(design, scenario)
    (kept,), (own,) = found.motion.axes, wanted.axes
    np.testing.assert_allclose(kept.motion.error, own.motion.error, rtol=1e-9, atol=1e-15)
    for leaf in (kept.motion.error, kept.motion.command, *kept.motion.state):
        assert leaf.base is None or leaf.base.size == leaf.size  # nothing of the others stays
