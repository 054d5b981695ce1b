"""Sensors and limits: observers, converters, what is not allowed."""

from pathlib import Path

import numpy as np
import pytest
from five_axes import five_axes
from sensed import scenario
from wording import refused, refused_command

import hfc_design.api as hfc
from hfc_design.files.design import Limits, design_json
from hfc_design.files.machine import measured_apart
from hfc_design.simulation.sensors import largest_command, observer_gains
from plants import C_AXIS, FEED_DRIVE

PERIOD = 1e-3


def test_observer_has_two_equal_poles():
    for bandwidth in (1.0, 30.0, 400.0):
        alpha, beta = observer_gains(bandwidth, PERIOD)
        poles = np.roots([1.0, alpha + beta - 2.0, 1.0 - alpha])
        assert poles == pytest.approx(np.exp(-2 * np.pi * bandwidth * PERIOD), abs=1e-6)


def test_largest_command_is_a_whole_number_of_steps():
    for command, resolution, wanted in (
        (120.0, 0.06, 120.0),
        (10.0, 0.6, 9.6),
        (1e300, 1e-20, 1e300),
    ):
        limits = Limits(command=command, resolution=resolution)
        assert largest_command(limits) == pytest.approx(wanted, rel=1e-15)
    assert largest_command(Limits(resolution=2.0)) is None


def test_signals_that_no_encoder_forms():
    assert measured_apart(C_AXIS) == ["current"]
    assert measured_apart(FEED_DRIVE) == []


def test_a_design_file_says_no_more_of_its_limits_than_it_has_to():
    assert Limits(command=5.0).model_dump() == {"command": 5.0}
    found = scenario("limits.resolution=0.5", "limits.delay_samples=1")
    text = design_json(hfc.with_gains(found, "pd", {"kp": 1.0, "kd": 1.0}))
    assert '"resolution": 0.5' in text
    plain = design_json(hfc.with_gains(scenario(), "pd", {"kp": 1.0, "kd": 1.0}))
    assert 'resolution"' not in plain.split('"provenance"')[0]
    assert "delay_samples" not in plain


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ("sensors.velocity='observer'", "sensors.observer_hz"),
        ("sensors.difference_samples=2", "sensors.difference_samples"),
        ("sensors.readings.deflection.noise=1", "sensors.readings.deflection"),
        ("sensors.readings.mood.noise=1", "sensors.readings.mood"),
        ("sensors.readings.current.noise=-1", "sensors.readings.current.noise"),
        ("limits={command=1,resolution=2}", "limits.resolution"),
    ],
)
def test_sensors_and_limits_that_are_not_allowed(change, where, tmp_path):
    found = refused_command("design", "c-axis-ramp", "--out", tmp_path / "run", "--set", change)
    assert found.startswith(f"hfc: c-axis-ramp: {where}")
    assert found.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "changes"),
    [
        ("G1 X5 F60\nX700", ["x.travel=[-10,600]"]),
        ("G1 X5 F60\nB5", []),
        ("G1 X5", []),
        ("G93 G1 X5 A3", []),
        ("M30", []),
        ("G0 X400", ["x.velocity_per_min=45000"]),
        ("G1 X5 F60", ["x.acceleration_time_s=0.4"]),
        ("G1 X5 F60", ["x.rapid_per_min=3e4", "x.velocity_per_min=2e4"]),
    ],
)
def test_bad_programs_are_one_clear_line(tmp_path, monkeypatch, text, changes):
    monkeypatch.chdir(tmp_path)
    with refused() as found:
        five_axes(Path(), text, *(f"reference.limits.{change}" for change in changes))
    assert "\n" not in found.refusal
    assert ("part.ngc" in found.refusal) == (not changes or "travel" in changes[0])


@pytest.mark.parametrize("change", ["start={w = 1.0}", "acceleration_mm_s2=50"])
def test_keys_that_have_no_meaning_here(tmp_path, change):
    with refused() as found:
        five_axes(tmp_path, "G1 X5 F60", f"reference.{change}")
    assert f"reference.{change[:5]}" in found.refusal


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("five-axis-program", "reference={kind = 'gcode', file = 'part.ngc'}"),
        ("five-axis-program", "reference={kind = 'circle', radius_mm = 5.0, feed_mm_min = 600.0}"),
        ("five-axis-program", "reference={kind='gcode', file='part.ngc', start={x = 1.0}}"),
        ("milling-table-circle", "reference={kind='circle', radius=5}"),  # told at once: two lines
    ],
)
def test_references_that_cannot_be_followed(tmp_path, monkeypatch, name, change):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.ngc").write_text("G1 X5 F60")
    with refused() as found:
        hfc.load_scenario(name, [change])
    assert found.refusal.count("\n") == ("radius=" in change)


@pytest.mark.parametrize(
    ("windows", "where"),
    [
        ('[{name="a", from_s=20.0}]', "windows.0: from_s"),
        ('[{name="a"}, {name="a", to_s=1.0}]', "windows.0.name"),
        ('[{name="a", to=1.0}]', "windows.0.to"),
    ],
)
def test_windows_that_cannot_be(windows, where):
    found = refused_command("score", "pd-only", "--set", f"windows={windows}")
    assert f": {where} = " in found
    assert found.count("\n") == 1


@pytest.mark.parametrize(
    "change",
    [
        "controller.nope=3",
        "controller.integral_gain.x=2",
        "plant.name=c-axis",
    ],
)
def test_changes_that_cannot_be(change):
    found = refused_command("score", "jee-koren-2004-flc", "--change", change)
    assert found.count("\n") == 1
