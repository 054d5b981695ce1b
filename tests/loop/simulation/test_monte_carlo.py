"""One design on machines that differ: each against its own run, stability against its poles."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.monte_carlo import drawn, robustness


def case(name, *changes, seconds=0.5):
    design = load_design(name)
    return design, own_scenario(design, name, [f"simulation.duration_s={seconds}", *changes])


def alone(design, scenario, machines, k):
    """``evaluate`` of machine ``k``, 0 the nominal one."""
    found = [{key: float(v[k]) for key, v in p._asdict().items()} for p in machines.true]
    if len(found) == 1:
        plant = PlantSettings(name=scenario.plant.name, parameters=found[0])
    else:
        plant = PlantSettings(name=scenario.plant.name, axes={"x": found[0], "y": found[1]})
    return evaluate(design, scenario.model_copy(update={"plant": plant}))


def test_quantiles_are_those_of_the_stable_machines():
    design, scenario = case("pd-only", seconds=2.0)
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


def test_the_seed_says_what_is_drawn():
    settings = load_scenario("feed-drive-circle").plant
    one, same, other = (drawn(settings, 0.2, 6, seed)[0].true for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one[0].gain[1:] != other[0].gain[1:]).all()
    more = drawn(settings, 0.2, 9, 1)[0].true
    np.testing.assert_array_equal(np.array(more)[..., :7], one)


@pytest.mark.parametrize("name", ["feed-drive-circle", "c-axis-ramp"])
def test_drawn_parameters_fill_their_range_and_nothing_else(name):
    settings = load_scenario(name).plant
    true = drawn(settings, 0.2, 400, 3)[0].true
    drives = settings.machine.drives
    for drive, nominal, found in zip(drives, settings.values(), true, strict=True):
        for key, value in nominal._asdict().items():
            column = getattr(found, key)
            assert column[0] == value
            if value == 0 or key in drive.exact:
                assert (column == value).all()
                continue
            factors = column[1:] / value
            assert factors.min() == pytest.approx(0.8, abs=0.01)
            assert factors.max() == pytest.approx(1.2, abs=0.01)
            assert factors.mean() == pytest.approx(1.0, abs=5 * 0.4 / np.sqrt(12 * 400))


def test_parameters_and_axes_are_independent():
    true = drawn(load_scenario("feed-drive-circle").plant, 0.2, 400, 3)[0].true
    varied = [column[1:] for axis in true for column in axis if np.ptp(column)]
    assert len(varied) == 2 * 8  # gain, time constant, six of the friction
    assert abs(np.corrcoef(varied) - np.eye(16)).max() < 5 / np.sqrt(400)


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


SHORT = ["--set", "simulation.duration_s=0.2", "--spread", "0.2", "--samples", "5"]


def test_the_command_tells_the_same_as_json_table_and_picture(tmp_path):
    done = hfc("score", "pd-only", *SHORT, "--seed", 4, "--json", "--plot", tmp_path / "a.png")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert (found["samples"], found["seed"], found["stable_share"]) == (5, 4, 1.0)
    design, scenario = case("pd-only", seconds=0.2)
    own = {"design": "pd-only", "scenario": "c-axis-ramp", "judged_by": scenario.judge().title}
    assert found == own | robustness(design, scenario, 0.2, 5, seed=4).numbers()
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert done.stderr.startswith("5 machines in ")
    table = hfc("score", "pd-only", *SHORT, "--seed", 4)
    assert max(map(len, table.stdout.splitlines())) <= 80
    assert "100 % of 5 machines are stable, the nominal one too" in table.stdout
    row = next(line for line in table.stdout.splitlines() if "rms_error_rad" in line)
    assert row.split()[1] == f"{found['metrics']['rms_error_rad']['nominal']:.3g}"


def test_the_nominal_motion_is_kept_and_no_other():
    design, scenario = case("pd-only", seconds=0.2)
    found = robustness(design, scenario, 0.2, 5)
    wanted = evaluate(design, scenario)
    (kept,), (own,) = found.motion.axes, wanted.axes
    np.testing.assert_allclose(kept.motion.error, own.motion.error, rtol=1e-9, atol=1e-15)
    for leaf in (kept.motion.error, kept.motion.command, *kept.motion.state):
        assert leaf.base is None or leaf.base.size == leaf.size  # nothing of the others stays
