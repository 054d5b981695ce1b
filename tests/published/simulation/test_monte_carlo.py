"""One design on machines that differ: each against its own run, stability against its poles."""

import numpy as np
import pytest
from jk04 import FRICTION
from one_by_one import alone, case
from run_folders import hfc
from scipy.signal import cont2discrete

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import monte_carlo
from hfc_design.simulation.monte_carlo import robustness
from hfc_design.stability.stable_range import stable_range
from plants.c_axis import coefficients


@pytest.mark.parametrize(
    ("name", "seconds"), [("lin-lee-1999-table-2", 1.5), ("jee-koren-2004-flc", 4.0)]
)
def test_every_machine_moves_as_it_does_alone(name, seconds, monkeypatch):
    design, scenario = case(name, seconds=seconds)
    monkeypatch.setattr(monte_carlo, "CHUNK", 4)  # three chunks, the last one filled up
    told = []
    found = robustness(design, scenario, 0.2, 8, 5, lambda *news: told.append(news))
    assert told == [(4, 9), (8, 9), (9, 9)]
    assert found.refined == 0
    for k in (0, 1, 4, 8):
        wanted = alone(design, scenario, found.machines, k)
        for key, value in {"fitness": wanted.fitness, **wanted.metrics}.items():
            mine = found.nominal[key] if k == 0 else found.values[key][k - 1]
            assert mine == pytest.approx(np.nan if value is None else value, rel=1e-9, nan_ok=True)
    assert np.ptp(found.values["fitness"]) > 0.01 * found.nominal["fitness"]


def test_stable_share_is_that_of_the_poles():
    period, gain, lag, count = 0.01, 28.3, 0.055, 120
    k_p = 0.97 * stable_range(gain, lag, period).k1_linear
    design = load_design("jee-koren-2004-pid")
    pid = design.controller.pid.model_copy(update={"k_p": k_p, "k_i": 0.0, "k_d": 0.0})
    controller = design.controller.model_copy(update={"pid": pid})
    changes = [
        f"plant.parameters={{gain={gain}, {', '.join(f'{name}=0.0' for name in FRICTION)}}}",
        "plant.axes={x={}, y={}}",
        "simulation.duration_s=20",
        "simulation.substeps=1",  # exact without friction
    ]
    scenario = load_scenario("feed-drive-circle", changes)
    found = robustness(design.model_copy(update={"controller": controller}), scenario, 0.2, count)

    def radius(gain, lag):
        """Of the slowest pole of K/(s (tau s + 1)) behind its hold, with u = k_p e."""
        numerator, denominator, _ = cont2discrete(([gain], [lag, 1.0, 0.0]), period)
        return abs(np.roots(denominator + k_p * numerator[0])).max()

    slowest = np.array(
        [
            max(radius(axis.gain[k], axis.time_constant[k]) for axis in found.machines.actual)
            for k in range(1, count + 1)
        ]
    )
    # In the 15 s before stability is looked at a disturbance of 1 BLU grows to a thousand, or a
    # hundredth of it is left.
    surely_unstable = slowest > 1000 ** (1 / 1500)
    surely_stable = slowest < 0.01 ** (1 / 1500)
    assert found.stable[surely_stable].all()
    assert not found.stable[surely_unstable].any()
    assert 0.2 < surely_stable.mean() <= found.stable.mean() <= 1 - surely_unstable.mean() < 0.8
    assert found.nominal_stable


def test_stable_spindles_are_those_of_the_linear_loop():
    design, scenario = case("pd-only", seconds=10.0)
    found = robustness(design, scenario, 0.2, 150)
    pd = design.controller.pd
    growth = []
    (true,) = found.machines.actual
    for k in range(1, 151):
        p = type(true)(*(float(v[k]) for v in true))
        c = coefficients(p)
        motor, spindle = c.inverse_rotor_inertia, c.inverse_spindle_inertia
        voltage = np.array([-pd.kp, -pd.kd]) * c.inverse_inductance
        matrix = [  # LL eq. 2 without bristles: current, rotor angle and speed, spindle likewise
            [-c.current_decay, 0.0, -c.back_emf, *voltage],
            [0.0, 0.0, 1.0, 0.0, 0.0],
            np.array([c.torque_constant, -p.stiffness, -p.rotor_damping, p.stiffness, 0]) * motor,
            [0.0, 0.0, 0.0, 0.0, 1.0],
            np.array([0.0, p.stiffness, 0.0, -p.stiffness, -p.viscous_friction]) * spindle,
        ]
        growth.append(np.linalg.eigvals(np.array(matrix)).real.max())
    growth = np.array(growth)
    # Of a disturbance at most exp(-7.5) is left in the last quarter; exp(2 * 7.5) friction, which
    # only damps, cannot hold. What is neither is decided by friction.
    assert found.stable[growth < -1].all()
    assert not found.stable[growth > 2].any()
    assert (growth > 2).sum() > 10
    assert 0.5 < (growth < -1).mean() <= found.stable.mean() <= (growth < 2).mean() < 1


SHORT = ["--set", "simulation.duration_s=0.2", "--spread", "0.2", "--samples", "5"]


def test_a_design_that_diverges_everywhere_is_a_result(tmp_path):
    design = load_design("pd-only")
    pd = design.controller.pd.model_copy(update={"kd": 1e9})
    wild = design.model_copy(update={"controller": design.controller.model_copy(update={"pd": pd})})
    (tmp_path / "wild.json").write_text(wild.model_dump_json())
    done = hfc("score", tmp_path / "wild.json", *SHORT, "--plot", tmp_path / "wild.svg")
    assert done.exit_code == 0, done.output
    assert "0 % of 5 machines are stable, the nominal one is not" in done.stdout
    assert "simulated again with shorter steps: 6" in done.stdout
    assert (tmp_path / "wild.svg").exists()
    assert done.stdout.endswith(f"\n{tmp_path / 'wild.svg'}\n")


def test_a_long_motion_is_simulated_in_smaller_chunks(monkeypatch):
    design, scenario = case("jee-koren-2004-pid", seconds=0.3)  # 30 samples of 2 axes
    monkeypatch.setattr(monte_carlo, "KEPT", 200)
    told = []
    robustness(design, scenario, 0.2, 8, progress=lambda *news: told.append(news))
    assert told == [(3, 9), (6, 9), (9, 9)]
