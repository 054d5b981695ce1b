"""Which observers are tried, what they are told apart by, and logs of other machines."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from carts import CART, EVERY, recorded
from shaken import shaken
from wording import refused

from hfc_design.identify.fit import bandwidths
from hfc_design.identify.identified import mismatched_logs
from hfc_design.identify.outcome import Check
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.recording import recording
from hfc_design.identify.replay import load_between
from hfc_design.identify.request import parameters_of, task_of
from hfc_design.identify.scenario import differences, linear_part, motions_like
from hfc_design.logs.signals import EvenLog
from plants.positioning_stage import POSITIONING_STAGE

WAVE = np.sin(0.05 * np.arange(4000))


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        (4000, [50.0, 20.0, 5.0]),  # 4 s at 1 kHz
        (1000, [50.0, 20.0]),  # ten periods of 5 Hz are 2 s
        (200, [50.0]),
        (120, [pytest.approx(10.0 / 0.12)]),  # slower ones see less than ten periods
    ],
)
def test_observers_that_suit_a_log(steps, expected):
    assert bandwidths(recorded(WAVE[:steps], WAVE[:steps]), None) == expected


def test_observers_that_do_not_are_refused():
    told = recorded(WAVE, WAVE)
    assert bandwidths(told, 0.0) == [0.0]
    assert bandwidths(told, 200.0) == [200.0]
    for wanted in (1.0, 201.0, float("nan")):
        with refused(ValueError):
            bandwidths(told, wanted)
    with refused(ValueError):
        bandwidths(recorded(WAVE[:99], WAVE[:99]), None)


def test_a_log_that_is_replayed_far_worse_is_of_another_machine():
    logs = {name: recorded(WAVE, WAVE) for name in ("own", "like", "unlike")}
    off = {"own": 1e-3, "like": 3e-3, "unlike": 5e-3}
    checks = [Check(name, "open loop", 1.0, x, WAVE) for name, x in off.items()]
    (line,) = mismatched_logs(checks, logs)
    assert line.startswith("DOUBTFUL: unlike is replayed 5 times worse than own (open loop)")
    assert not mismatched_logs([one._replace(how=one.log) for one in checks], logs)
    lost = [checks[0], checks[1]._replace(after=float("nan"))]
    assert len(mismatched_logs(lost, logs)) == 1


def test_an_observer_that_is_just_slow_enough_is_tried():
    """Ten samples a period: 50 Hz at 2 ms, which time stamps tell to some digits only."""
    for every, expected in ((0.002, [50.0, 20.0, 5.0]), (0.005, [20.0, 5.0]), (0.02, [5.0])):
        for (period,) in shaken(every, size=1e-9):
            told = recorded(WAVE, WAVE)._replace(sample_time=period)
            assert bandwidths(told, None) == expected
            assert bandwidths(told, 0.2 / every) == [0.2 / every]
            least = recorded(WAVE[:100], WAVE[:100])._replace(sample_time=period)
            assert bandwidths(least, None) == [pytest.approx(0.1 / period)]


@pytest.mark.parametrize("place", [0.0, 0.1, 0.7, -3.3])
def test_an_axis_that_stands_begins_at_rest(place):
    """Of a log without noise the slope of a straight line is a few last bits, and is none."""
    values = place + np.where(WAVE * 0.0 + np.arange(4000) > 100, WAVE, 0.0)
    found = EvenLog(0.001, {"place": values}, WAVE < 2.0, [])
    drive = replace(POSITIONING_STAGE, feedback=("place", "velocity"))
    assert recording(found, drive).rate == 0.0


def test_a_load_that_swings_is_not_cut_short():
    """Four points know its middle to the fourth order; straight lines are off by (w T)^2 / 8."""
    every, w = 1e-3, 50.0
    time = every * np.arange(200)
    load = np.sin(w * time)
    start, middle, end = load_between(load, 1).T
    exact = np.sin(w * (time + 0.5 * every))[1:-2]
    straight = 0.5 * (load[:-1] + load[1:])[1:-1]
    middle = middle[1:-2]
    assert np.abs(straight - exact).max() == pytest.approx((w * every) ** 2 / 8, rel=0.01)
    assert np.abs(middle - exact).max() < 1e-3 * (w * every) ** 2
    np.testing.assert_array_equal(start, load)
    np.testing.assert_allclose(end[:-1], load[1:], atol=1e-15)


def wanted(plant, changes, names=None):
    return parameters_of(task_of(plant, None, changes, None, None, names, None, 0))


def test_a_load_is_looked_for_where_no_parameter_is_one():
    assert "load" in wanted("milling-table", ()).names
    assert "load" not in wanted("positioning-stage", ()).names
    assert "load" in wanted("positioning-stage", (), ["mass", "load"]).names


def test_what_is_set_is_known_and_listed():
    changes = {"plant.parameters.torque_gain": 2.5, "load.constant": 530, "limits.lag_s": 0.0005}
    found = wanted("milling-table", changes | {"plant.parameters.lead": 10.0})
    assert not {"torque_gain", "load", "lead"} & {*found.names}
    assert found.sought.tolist() == [1.0, 0.0]
    for told in ("load 530 N", "torque_gain 2.5 N m/V", "lead 10 mm/rev"):
        assert told in found.rest()
    assert "table_mass 100 kg" in found.wanted()
    assert "lag_s known to be" in found.wanted()


def test_a_start_is_said_beside_the_name():
    found = wanted("milling-table", (), ["table_mass=180", "load=20"])
    assert found.starts["table_mass"] == 180.0
    assert found.values(found.begun) == pytest.approx([180.0, 20.0])


def test_only_what_units_explain_is_said_to_be_far_from_where_it_began():
    """Machines of 97 times the mass of the built-in stage exist, and of 0.004 times the drag."""
    cart = free_parameters(CART, {}, ("mass", "viscous_friction"))
    for factor, told in ((97.3, 0), (0.0042, 0), (1.5, 0), (1020.0, 1), (1e-3, 1), (1 / 57, 1)):
        numbers = np.append(np.log([factor, 1.0]), [0.0, 0.0])
        assert list(cart.away(numbers)) == ["mass"] * told


PLACE = 1e-6 * np.round(2e4 * np.sin(0.02 * np.arange(2000)))


@pytest.mark.parametrize("samples", [1, 4, 16])
def test_a_velocity_is_a_difference_over_samples(samples):
    """By the control, which prints six digits; one that is measured apart is none."""
    told = recorded(PLACE, PLACE)
    rate = np.zeros(len(PLACE))
    rate[samples:] = (PLACE[samples:] - PLACE[:-samples]) / (samples * EVERY)
    with_rate = told._replace(outputs=told.outputs | {"velocity": np.round(rate, 6)})
    expected = {"difference_samples": samples} if samples > 1 else {}
    assert differences(with_rate, "velocity") == expected
    assert differences(told, "velocity") == {}
    smooth = 0.4 * np.cos(0.02 * np.arange(2000))
    assert differences(told._replace(outputs={"velocity": smooth} | told.outputs), "velocity") == {}


@pytest.mark.parametrize(("error", "height"), [(0.002, 0.1), (1.0, 3.0)])
def test_the_scale_tells_a_step_that_is_made(error, height):
    """Three times the error of the log's loop, and a hundred steps of the scale at least."""
    told = SimpleNamespace(place=np.array([0.0, 10.0]), step=0.001)
    found = motions_like(told, speed=5.0, acceleration=50.0, duration=3.0, error=error)
    assert found[-1]["reference"] == {"kind": "step", "height": height}


@pytest.mark.parametrize(
    ("feedback", "logged", "read"),
    [
        ("position", ["position"], {}),  # a motor has an encoder of its own
        ("motor_position", ["motor_position", "position"], {}),
        ("motor_position", ["motor_position"], {"signals": []}),
        ("motor_position", ["motor_position", "motor_velocity"], {"signals": []}),
    ],
)
def test_a_law_reads_no_scale_that_no_log_shows(feedback, logged, read):
    own = task_of("milling-table", None, {"sensors.feedback": feedback}, None, None, None, None, 0)
    told = SimpleNamespace(outputs=dict.fromkeys(logged))
    assert linear_part(*own.scenario.machine.drives, told) == read


def test_beside_a_rotor_alone_a_law_reads_its_current():
    changes = {"sensors.feedback": "rotor_angle"}
    own = task_of("c-axis", None, changes, None, None, None, None, 0)
    told = SimpleNamespace(outputs={"rotor_angle": None})
    assert linear_part(*own.scenario.machine.drives, told) == {"signals": ["current"]}
