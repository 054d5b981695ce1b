"""The bench of foreign machines: its simulator against hand calculations, its harness, its logs."""

import tomllib

import numpy as np
import pytest

from experiments.foreign_machines import bench
from experiments.foreign_machines.bench import OTHER, TRUE, Law
from hfc_design.files.loop_setup import load_design
from hfc_design.formats.code import sources
from hfc_design.formats.writing import write

FREE = {"ratio": 1.0, "load_mass": 2.0, "command_limit": 1e3, "torque_limit": 1e3, "gain": 1.0}
DT = bench.STEP


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return bench.simulator(tmp_path_factory.mktemp("bench"))


def pushed(program, commands, sample_time=DT, **parameters):
    """What a machine does under given commands: a PID whose gains are all 0."""
    law = Law(program.pid, gains={})
    still = np.zeros((len(commands), 3))
    own = FREE | parameters
    return bench.simulated(program, own, law, still, sample_time, 1.0, np.asarray(commands, float))


def test_two_masses_keep_energy_momentum_and_period(program):
    heavy, light, spring = 3.0, 2.0, 5e5
    commands = np.zeros(50_000)
    commands[:20] = 100.0
    found = pushed(program, commands, motor_inertia=heavy, stiffness=spring)
    load, motor = found[:, TRUE], found[:, OTHER]
    middle = (heavy * motor + light * load) / (heavy + light)
    impulse = 100.0 * 20 * DT
    assert np.diff(middle[20:]) / DT == pytest.approx(impulse / (heavy + light), rel=1e-6)
    swing = (motor - load)[100:]
    hz = np.sqrt(spring * (1 / heavy + 1 / light)) / (2 * np.pi)
    up = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))
    at = up - swing[up] / (swing[up + 1] - swing[up])
    assert (len(at) - 1) / (DT * (at[-1] - at[0])) == pytest.approx(hz, rel=1e-5)
    rates = [np.gradient(x, DT)[100:] for x in (motor, load)]
    energy = 0.5 * (heavy * rates[0] ** 2 + light * rates[1] ** 2 + spring * swing**2)
    periods = energy[: len(energy) // 2].mean(), energy[len(energy) // 2 :].mean()
    assert periods[1] == pytest.approx(periods[0], rel=1e-4)


def test_friction_holds_below_break_away_and_slides_above(program):
    rub = {"coulomb": 6.0, "breakaway": 8.0, "stribeck_speed": 1e-3, "presliding": 1e-6}
    # A sudden force would overshoot: the bristle is a spring.
    held = pushed(program, np.minimum(np.linspace(0.0, 15.8, 50_000), 7.9), **rub)
    assert np.ptp(held[30_000:, TRUE]) < 1e-9
    assert abs(held[:, TRUE]).max() < rub["presliding"] * 1.2
    speed = np.diff(pushed(program, np.full(50_000, 9.0), **rub)[:, TRUE]) / DT
    gained = (speed[-1] - speed[-10_001]) / (10_000 * DT)
    assert gained == pytest.approx((9.0 - 6.0) / FREE["load_mass"], rel=1e-6)


@pytest.mark.parametrize(("delay", "lag"), [(0.0, 0.0), (2.3e-3, 0.0), (1e-3, 0.7e-3)])
def test_a_command_is_as_late_as_it_is_said_to_be(program, delay, lag):
    """By cross-correlation with the acceleration, whose second difference is half a sample late."""
    sample, rng = 1e-3, np.random.default_rng(1)
    u = rng.choice([-1.0, 1.0], 40_000)
    place = pushed(program, u, sample, delay_s=delay, lag_s=lag)[:, TRUE]
    acceleration = np.diff(place, 2) / sample**2
    columns = np.stack([u[20 - k : len(u) - 20 - k] for k in range(12)], axis=1)
    answer = np.linalg.lstsq(columns, acceleration[19 : len(u) - 21], rcond=None)[0]
    assert answer.sum() == pytest.approx(1.0 / FREE["load_mass"], rel=1e-3)
    late = sample * (np.arange(12) @ answer / answer.sum() - 0.5)
    assert late == pytest.approx(delay + lag, abs=2e-5)


def test_a_load_hangs_on_its_flank_and_falls_freely(program):
    own = {"motor_inertia": 3.0, "stiffness": 1e6, "gap": 1e-4, "pull": 20.0}
    held = pushed(program, np.full(2_000, 20.0), **own)
    assert abs(held[:, [TRUE, OTHER]]).max() < 1e-12
    down = pushed(program, np.full(2_000, -100.0), **own)
    apart = own["gap"] / 2 + 20.0 / own["stiffness"] + down[:, OTHER] - down[:, TRUE]
    first = np.argmax(apart < 0.5 * own["gap"]), np.argmax(apart <= -0.5 * own["gap"])
    motor, time = -100.0 / 3.0, DT * (first[1] - first[0])
    assert first[1] > first[0] > 0
    speed = np.diff(down[:, TRUE]) / DT
    between = speed[first[0] + 2 : first[1] - 2]
    assert np.diff(between) / DT == pytest.approx(-20.0 / FREE["load_mass"], rel=1e-4)
    relative = abs(motor + 20.0 / FREE["load_mass"])
    assert time < np.sqrt(2.0 * own["gap"] / relative) + DT


def test_an_exported_loop_does_what_the_same_gains_do_in_the_simulator(program, tmp_path):
    design = load_design("emps-cascade")
    write(tmp_path, sources(design))
    sensors = {"velocity": "encoder", "difference_samples": 2}
    law = bench.exported(tmp_path, {"sensors": sensors})
    axis = {"load_mass": 95.0, "gain": 35.0, "coulomb": 20.0, "breakaway": 25.0, "presliding": 1e-6}
    own = FREE | axis | {"load_encoder": 5e-8, "delay_s": 1e-3, "command_limit": 10.0}
    reference = bench.moved([(20.0, 50.0, 500.0, 0.2), (-20.0, 50.0, 500.0, 0.5)], 1e-3)
    gains = {"kp": design.controller.kp, "kd": 0.24345, "speed": -0.24345}
    same = Law(program.pid, difference_samples=2, gains=gains)
    found, expected = (
        bench.simulated(program, own, one, reference, 1e-3, 1e3) for one in (law, same)
    )
    assert np.ptp(found[:, TRUE]) > 19.0
    assert found == pytest.approx(expected, abs=1e-9)
    with pytest.raises(ValueError, match="motor's encoder alone"):
        bench.exported(tmp_path, {"sensors": sensors | {"feedback": "motor_position"}}, scale=False)


@pytest.mark.parametrize("name", bench.machines())
def test_a_machine_is_written_as_its_drive_would_see_it(program, tmp_path, name):
    machine = bench.machines()[name]
    bench.write_log(program, machine, tmp_path / "log.csv")
    told = machine.told["log"]
    lines = (tmp_path / "log.csv").read_text().splitlines()[len(told["head"]) :]
    assert 10.0 < len(lines) * machine.sample_time < 20.0
    rows = (line.replace(told["decimal"], ".").split(told["separator"]) for line in lines)
    values = [[float(x) for x in row] for row in rows]
    columns = dict(zip([c[0] for c in told["columns"]], np.transpose(values), strict=True))
    scale = {c[0]: c[1] for c in told["columns"]}
    off = columns["reference"] / scale["reference"] - columns["position"] / scale["position"]
    assert np.abs(off).max() < 0.05 * machine.told["run"]["distance"]
    assert np.abs(columns["command"]).max() / scale["command"] < 7.0


def test_motions_are_read_from_a_run(tmp_path):
    text = """
[simulation]
duration_s = 1.0
[fitness]
settled_after_s = 0.4
[[motions]]
name = "move"
reference = { kind = "trapezoidal", distance = 4.0, velocity = 8.0, acceleration = 32.0 }
[[motions]]
name = "sine"
settled_after_s = 0.6
reference = { kind = "sine", amplitude = 2.0, frequency_rad_s = 5.0 }
"""
    found = bench.scenario_motions(tomllib.loads(text), 1e-3)
    move, settled, steady = found["move"]
    assert (settled, steady, found["sine"][1:]) == (0.4, True, (0.6, False))
    assert move[375] == pytest.approx([2.0, 8.0, 0.0])
    assert move[-1] == pytest.approx([4.0, 0.0, 0.0])
    for samples in (move, found["sine"][0]):
        rate = np.gradient(samples[:, 0], 1e-3)[1:-1]
        assert rate == pytest.approx(samples[1:-1, 1], abs=0.02)
