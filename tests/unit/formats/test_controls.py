"""Parameters of controls against hand calculations; what they lack is refused."""

import json
import re

import numpy as np
import pytest
from exported import with_controller, with_scenario
from places import ROOT
from wording import refused, refused_command

from hfc_design import runtime
from hfc_design.calls.searching import with_gains
from hfc_design.files.design import named_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats.controls import CONTROLS, Row, parameters

EVERY = 0.005
#: A table has 0.14 N m/V, 5 mm a turn, 0.05 N m and 300 N of friction, and 0.4 mm of backlash.
TURN = 2.0 * np.pi / 5.0
PID = load_design("huang-pid", {"controller.pid": {"k_p": 40.0, "k_i": 300.0, "k_d": 0.5}})
LOAD = {"load": 1.0, "expected_load": 1.0}


def pid_ff(scenario="milling-table-circle", *changes, **gains):
    loaded = load_scenario(scenario, ["controller={kind='pid+ff'}", *changes])
    forward = gains.pop("feed_forward", {})
    gains = {"kp": 40.0, "ki": 300.0, "kd": 0.5} | gains | {"feed_forward": forward}
    return with_gains(loaded, "pid+ff", gains)


def values(control, design, **given):
    """Parameters of an only axis, or of X."""
    found = json.loads(parameters(control, design, **given)["parameters.json"])
    return found.get("x", found)


@pytest.mark.parametrize("design", [PID, pid_ff()], ids=["pid", "pid+ff"])
def test_a_pid_is_a_cascade_in_every_sample(design):
    """Speed controller with the commanded speed fed forward; the rates are differences."""
    found = values("siemens", design)
    kv, tn = found["MD32200 POSCTRL_GAIN"] / 0.06, found["p1462"] / 1000.0
    kp = found["p1460"] * TURN / 0.14
    errors = np.append(0.0, np.random.default_rng(1).normal(0.0, 0.01, 300))
    controller, summed = runtime.Controller(design), 0.0
    still = {"reference_rate": 0.0, "reference_acceleration": 0.0}
    for before, error in zip(np.append(0.0, errors), errors, strict=False):
        rate = (error - before) / EVERY
        speed_error = kv * error + rate
        summed += speed_error * EVERY
        command = controller.step({"error": error, "error_rate": rate, **still})
        assert command == pytest.approx(kp * (speed_error + summed / tn), abs=2e-6)


def test_the_pulse_of_the_friction_compensation_steps_the_torque():
    found = values("siemens", PID)
    time, dt = np.linspace(0.0, 0.1, 100_001, retstep=True)
    decay = np.exp(-time / found["MD32540 FRICT_COMP_TIME"])
    pulse = found["MD32520 FRICT_COMP_CONST_MAX"] / 60.0 * decay * TURN  # rad/s
    summed = np.cumsum(0.5 * dt * (pulse[1:] + pulse[:-1])) / (found["p1462"] / 1000.0)
    torque = found["p1460"] * (pulse[1:] + summed)
    wanted = 2.0 * (0.05 + 300.0 * 0.005 / (2.0 * np.pi))
    np.testing.assert_allclose(torque, wanted, rtol=1e-5)


#: Of 40, 300 and 0.5: z^2 - 80 z + 600 has the roots 40 +- sqrt(1000); 0.5 V s/mm are KP N m s/rad.
KV, BY_TN, KP = 40.0 - 1000.0**0.5, 40.0 + 1000.0**0.5, 0.5 * 0.14 / TURN


@pytest.mark.parametrize(
    ("control", "wanted"),
    [
        ("beckhoff", {"S-0-0104": 0.06 * KV, "S-0-0100": KP, "S-0-0101": 1e3 / BY_TN}),
        ("beckhoff", {"NC Proportional factor Kv": KV, "0x3140:02": 1.0 / BY_TN}),
        ("siemens", {"MD32200 POSCTRL_GAIN": 0.06 * KV, "MD32620 FFW_MODE": 3.0}),
        ("heidenhain", {"MP_kvFactor": KV, "MP2500": 2.0 * np.pi * KP / 0.8, "MP_backLash": 0.4}),
        ("heidenhain", {"MP1510": 0.06 * KV, "MP2510": 2.0 * np.pi * KP * BY_TN / 0.8}),
        ("odrive", {"pos_gain": KV, "vel_gain": 2.0 * np.pi * KP}),
        ("odrive", {"vel_integrator_gain": 2.0 * np.pi * KP * BY_TN}),
        ("simplefoc", {"P_angle.P": KV, "PID_velocity.P": 0.5 / TURN}),
        ("simplefoc", {"PID_velocity.I": 0.5 / TURN * BY_TN}),
        ("linuxcnc-pid", {"P": 40.0, "I": 300.0, "D": 0.5, "MAX_OUTPUT": 10.0, "BACKLASH": 0.4}),
    ],
)
def test_units_by_hand(control, wanted):
    """The encoder is at the motor, before the backlash."""
    design = with_scenario(PID, "milling-table-circle", "sensors.feedback=motor_position")
    found = values(control, design, motor={"torque_constant": 0.8})
    assert {name: found[name] for name in wanted} == pytest.approx(wanted, rel=1e-6)


def test_feed_forward_by_hand():
    """100 kg on a screw of 10 mm: 100 (0.01 / 2 pi)^2 kg m2, for 1 N/V and 0.1 V s2/mm."""
    stage = ("positioning-stage-move", "plant.parameters.amplifier_gain=1")
    design = pid_ff(*stage, ki=0.0, feed_forward={"acceleration": 0.1})
    found = values("siemens", design, motor={"lead": 10.0})
    assert found["MD32650 AX_INERTIA"] == pytest.approx(100.0 * (0.01 / (2.0 * np.pi)) ** 2)
    assert (found["MD32620 FFW_MODE"], found["p1462"]) == (4.0, 0.0)  # without ki no integral
    assert found["MD32200 POSCTRL_GAIN"] == pytest.approx(0.06 * 80.0)
    turns = values("odrive", design, motor={"lead": 10.0})["inertia"]
    assert turns == pytest.approx(2.0 * np.pi * found["MD32650 AX_INERTIA"], rel=1e-6)


def test_angles_are_degrees_and_friction_goes_to_the_bias():
    forward = {"velocity": 2.0, "coulomb": 3.0, "coulomb_width": 0.1, "load": 2.0}
    forward |= {"expected_load": 0.5}
    design = pid_ff("c-axis-ramp", kp=900.0, ki=1000.0, kd=100.0, feed_forward=forward)
    found = values("linuxcnc-pid", design)
    wanted = {"P": 899.0 * np.pi / 180.0, "FF1": 2.0 * np.pi / 180.0, "FRICTION": 3.0}
    wanted |= {"BIAS": 1.0, "FRICTION_SPEED": 18.0 / np.pi}
    assert {name: found[name] for name in wanted} == pytest.approx(wanted, rel=1e-6)
    hal = parameters("linuxcnc-pid", design)["pid.hal"]
    assert "net spindle-velocity => pid.feedback-deriv" in hal  # its tachometer
    assert "net bias bias.out => pid.bias" in hal


@pytest.mark.parametrize(
    ("control", "made", "about"),
    [
        ("linuxcnc-pid", lambda: pid_ff(derivative_hz=50.0), "controller.derivative_hz"),
        ("siemens", lambda: pid_ff(feed_forward={"velocity": 1.0}), "feed_forward.velocity"),
        ("odrive", lambda: pid_ff(feed_forward=LOAD), "load"),
        ("linuxcnc-pid", lambda: with_controller(PID, dead_zone=0.01), "controller.dead_zone"),
        (
            "linuxcnc-pid",
            lambda: pid_ff("milling-table-circle", "sensors={velocity='observer',observer_hz=50}"),
            "sensors.observer",
        ),
        # (kp - 0.005 ki)^2 = 4 ki kd at 671.4, for a sample every 5 ms.
        ("siemens", lambda: pid_ff(ki=671.5), "ki 0 to 671.4"),
        (
            "beckhoff",
            lambda: pid_ff(feed_forward={"coulomb": 1.0, "coulomb_width": 1.0, **LOAD}),
            "lacks controller.feed_forward.coulomb, controller.feed_forward.load",
        ),
        ("siemens", lambda: pid_ff(kd=0.0), "kd must be more than 0"),
        (
            "siemens",
            lambda: pid_ff(kd=1e-3, ki=0.0),
            "POSCTRL_GAIN = 2400 [1000/min]: must be 0 to 2000",
        ),
        ("siemens", lambda: pid_ff("positioning-stage-move"), "lead, torque"),
        ("heidenhain", lambda: PID, "torque_constant"),
        ("siemens", lambda: named_design("jee-koren-2004-flc"), "of kind flc"),
        ("klipper", lambda: PID, "stress.modes"),
    ],
)
def test_what_a_control_lacks_is_refused(control, made, about):
    design = made()
    with refused() as found:
        parameters(control, design)
    assert about in found.refusal


def test_options_of_other_formats_and_wrong_data_are_refused():
    assert "--motor" in refused_command("export", "huang-pid", "--to", "c", "--motor", "lead=5")
    for data in ("led=5", "lead=0", "lead=a"):
        assert data[:4] in refused_command("export", "huang-pid", "--to", "odrive", "--motor", data)


def test_modes_become_lines_of_klipper():
    modes = "stress.modes=[{hz=45,damping=0.05},{hz=52}]"
    design = with_scenario(PID, "milling-table-circle", modes)
    assert parameters("klipper", design)["input_shaper.cfg"].splitlines() == [
        *("[input_shaper]", "shaper_type: mzv", "shaper_freq_x: 45.0", "damping_ratio_x: 0.05"),
        *("shaper_freq_y: 52.0", "damping_ratio_y: 0.02"),
    ]


INI = """[EMC]
P = 1
[JOINT_0]
P = 12.5  # volts
MAX_OUTPUT = 9
[JOINT_1]
I = 2
"""


@pytest.mark.parametrize(
    ("name", "text", "restored"),
    [
        ("old.ini", INI, "[JOINT_0]\nP = 12.5\nMAX_OUTPUT = 9.0\n[JOINT_1]\nI = 2.0\n"),
        (
            "old.hal",
            "setp pid.0.Pgain 12.5\nsetp y-pid.Igain 2\nsetp pid.0.Igain [JOINT_0]I\n",
            "[JOINT_0]\nP = 12.5\n[JOINT_1]\nI = 2.0\n",
        ),
        ("old.json", '{"x": {"P": 12.5}}', "[JOINT_0]\nP = 12.5\n[JOINT_1]\n"),
    ],
)
def test_old_values_are_listed_and_can_be_put_back(name, text, restored, tmp_path):
    (tmp_path / name).write_text(text)
    files = parameters("linuxcnc-pid", PID, old=tmp_path / name)
    assert files["restore.ini"] == restored
    assert "| `P` | 12.5 | 40 | command/mu |" in files["README.md"]
    (tmp_path / "again.json").write_text(files["restore.json"])
    again = parameters("linuxcnc-pid", PID, old=tmp_path / "again.json")
    assert again["restore.ini"] == restored


def test_files_without_old_values_are_refused(tmp_path):
    (tmp_path / "old.json").write_text('{"x": 5, "P": "a"}')
    with refused() as found:
        parameters("linuxcnc-pid", PID, old=tmp_path / "old.json")
    assert found.where.endswith("old.json")


@pytest.mark.parametrize("name", CONTROLS)
def test_every_parameter_is_in_the_manual_with_its_source(name):
    page = (ROOT / "docs" / "controls.md").read_text()
    words = " ".join(page.split())
    control = CONTROLS[name]
    for row in (Row(*row) for row in control["parameters"]):
        line = (
            rf"^\| `{re.escape(row.name)}` \| {re.escape(row.meaning)} \| {re.escape(row.unit)} \|"
        )
        [found] = re.findall(line + r" (.*) \|$", page, re.M)
        assert found.startswith(row.source)
        keys = [part.split()[0] for part in row.source.split(", ")]
        assert all(key in control["sources"] for key in keys)
    assert all(source in words for source in control["sources"].values())
