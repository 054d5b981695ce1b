"""What a design stands, against poles by SciPy and static errors by hand."""

from itertools import product

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import cont2discrete

from hfc_design.api import with_gains
from hfc_design.core.records import UserError
from hfc_design.files.loop_setup import controller_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.loop_margins import AskedMargins
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import one_machine
from hfc_design.simulation.stress import PARTS, Applied, _load_first, _resting, loads, rubbing
from hfc_design.simulation.usable import BEYOND, usable
from hfc_design.stability.margins import swung
from plants.around import GOLDEN

PERIOD, KP, KD = 1e-3, 20.0, 0.3  # V/mm, V s/mm
GAIN, DRAG, MASS = 35.1507, 203.5, 95.11
#: Nothing but what a test asks for.
NONE = {
    **dict.fromkeys(("delay_samples", "lag_samples", "load", "backlash_steps", "jitter"), 0.0),
    **{"noise": 1.0, "friction": 1.0, "start": 0.0, "rest_s": 0.0, "mode_inertia": []},
    **{"backwards": 0.0, "sticking": 0.0},
    "machines": 2,
}
#: A stage without friction, which the poles of a linear loop describe.
STAGE = {
    "plant": {
        "name": "positioning-stage",
        "parameters": {"coulomb_friction": 0.0, "offset": 0.0},
    },
    "simulation": {"duration_s": 2.0, "sample_time_s": PERIOD},
    "reference": {"kind": "trapezoidal", "distance": 5.0, "velocity": 50.0, "acceleration": 2000.0},
    "robust": {
        "spread": 1e-6,
        **{"unseen": 3, "first": 2, "machines": 2, "elite": 2, "final": 2},
    },
    "fitness": {"kind": "tolerances", "tolerances": {"rms_error": 1.0}},
    "controller": {"kind": "pid+ff"},
}


def found(robust=STAGE["robust"], changes=None, ki=0.0, **stress):
    scenario = load_scenario({**STAGE, "robust": robust, "stress": NONE | stress}, changes)
    return usable(with_gains(scenario, "pid+ff", {"kp": KP, "kd": KD, "ki": ki}), scenario)


def radius(delay=0, hz=0.0, damping=0.0, share=0.0, gains=(KP, KD)):
    """Of the closed loop's largest pole, with whole samples of delay and a mode in the force."""
    a = np.array([[0.0, 1.0, 0, 0], [0, -DRAG / MASS, 0, 0], [0, 0, 0, 1.0], [0, 0, 0, 0]])
    b = np.array([[0.0], [1e3 * GAIN / MASS], [0.0], [1.0]])
    w = 2.0 * np.pi * hz
    a[3, 2:] = -(w**2), -2.0 * damping * w
    a[1] += 1e3 * GAIN / MASS * share * a[3]  # the force is u + share s'', s'' = u - ...
    b[1] *= 1.0 + share
    ad, bd, *_ = cont2discrete((a, b, np.eye(4), np.zeros((4, 1))), PERIOD)
    fed = -np.array([[*gains, 0.0, 0.0]])
    if not hz:
        ad, bd, fed = ad[:2, :2], bd[:2], fed[:, :2]
    for _ in range(delay):
        size = len(ad)
        ad = np.block([[ad, bd], [np.zeros((1, size + 1))]])
        bd = np.vstack([np.zeros((size, 1)), [[1.0]]])
        fed = np.hstack([fed, [[0.0]]])
    return np.abs(np.linalg.eigvals(ad + bd @ fed)).max()


def test_a_delay_breaks_the_loop_where_its_poles_do():
    own = found(delay_samples=16.0)
    (row,) = own.stress
    sizes = 16.0 * np.append(PARTS, 1.0)
    unstable = [radius(int(x)) > 1.0 for x in sizes]
    assert any(unstable)
    assert not all(unstable)
    assert row.part == sizes[int(np.argmax(unstable))] / 16.0
    assert not row.holds
    assert row.why.startswith(("oscillates", "diverges", "stays at a limit"))
    assert own.verdict == "on this model only"
    untried = own._replace(stress=())
    assert untried.verdict == "yes"
    assert untried.answer.endswith("not tested under stress, add [robust] or [stress] for that")
    assert own.answer.startswith("on this model only: 100 % of 3 unseen machines")
    assert f"a delay {row.part * 16:g} samples longer" in own.answer
    assert not own.numbers()["usable"]


def test_a_far_mode_breaks_the_loop_where_its_poles_do():
    own = found(modes=[{"hz": 60.0, "damping": 0.02}])
    (row,) = own.stress
    parts = np.append(PARTS, 1.0)
    unstable = [radius(0, 60.0, 0.02, -x) > 1.0 for x in parts]
    assert any(unstable)
    assert not all(unstable)
    assert (row.part, row.holds) == (parts[int(np.argmax(unstable))], False)


def test_where_a_mode_would_lead_a_loop_is_told_by_the_loop_without_it():
    """Near -1 the circle is but nearly one."""
    a, b = np.array([[0.0, 1.0], [0.0, -DRAG / MASS]]), np.array([[0.0], [1e3 * GAIN / MASS]])
    ad, bd, *_ = cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), PERIOD)
    unstable = []
    for hz, share in product((30.0, 60.0, 100.0, 170.0, 240.0), (0.1, 0.5, -0.3, -1.0)):
        for gains in ((20.0, 0.3), (60.0, 0.6), (20.0, 1.5), (5.0, 2.5)):
            z = np.exp(2j * np.pi * hz * PERIOD)
            loop = gains @ np.linalg.solve(z * np.eye(2) - ad, bd)[:, 0]
            near = swung(loop, 0.02, share)
            if abs(near - 1.0) > 0.2:
                unstable.append(radius(0, hz, 0.02, share, gains) > 1.0)
                assert unstable[-1] == (near > 1.0), (hz, share, gains, near)
    assert len(unstable) > 60
    assert 0.2 < np.mean(unstable) < 0.8


@pytest.mark.parametrize(
    ("lowest", "at"), [(120.0, "load"), (200.0, "load"), (247.0, "load"), (200.0, "drive")]
)
def test_a_search_looks_where_the_answer_tries_a_mode(lowest, at):
    """Of a loop by SciPy: nearest to -1 the lowest mode leads it, between two of a coarse grid."""
    stress = {"stress.unknown_above_hz": lowest, "stress.encoder_at": at}
    changes = {"constraints.sensitivity": 99.0} | stress
    scenario = load_scenario(STAGE, changes)
    controller, gains = controller_of(
        with_gains(scenario, "pid+ff", {"kp": KP, "kd": KD}), scenario
    )
    asked = AskedMargins(scenario, closed_loop(scenario, controller))
    a, b = np.array([[0.0, 1.0], [0.0, -DRAG / MASS]]), np.array([[0.0], [1e3 * GAIN / MASS]])
    ad, bd, *_ = cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), PERIOD)
    z = np.exp(2j * np.pi * np.geomspace(lowest, 250.0, 4) * PERIOD)
    loops = [(KP, KD) @ np.linalg.solve(one * np.eye(2) - ad, bd)[:, 0] for one in z]
    every = product(loops, (0.1 / 0.9, 0.5, *[-1.0] * (at == "load")))
    near = max(0.0, *(float(swung(loop, 0.02, share)) for loop, share in every))
    assert asked.margins(gains)["modes"].max() == pytest.approx(near, rel=1e-6)


def test_a_stress_that_the_loop_stands_is_no_reason():
    assert radius(2) < 1.0
    own = found(delay_samples=2.0, rest_s=2.0, start=0.1, jitter=0.1)
    assert [one.holds for one in own.stress] == [True] * 4
    assert own.verdict == "yes"
    assert own.numbers()["usable"]


@pytest.mark.parametrize(
    ("plant", "name", "level"),
    [
        ("c-axis", "static_torque", 1.2 + 0.5 * 0.7),
        ("milling-table", "stiction_rise", 30.0 + 0.5 * 60.0),
        ("positioning-stage", "stiction_rise", 0.5 * 20.39),
    ],
)
def test_friction_at_rest_is_larger_by_a_share_of_that_of_coulomb(plant, name, level):
    parameters = {"coulomb_friction": 60.0, "stiction_rise": 30.0} if plant[0] == "m" else {}
    scenario = load_scenario({"plant": {"name": plant, "parameters": parameters}})
    (one,), (more,) = (
        rubbing(scenario, one_machine(scenario.plant.values()), Applied(sticking=share)).actual
        for share in (0.0, 0.5)
    )
    assert {key: x for key, x in more._asdict().items() if x != getattr(one, key)} == {
        name: pytest.approx([level])
    }


@pytest.mark.parametrize("times", [0.8, 1.2])
def test_a_load_is_where_the_static_error_is_too_large(times):
    """Without an integral a load leaves F / (gain kp); far off is more than 5 % of the way."""
    load = times * 0.05 * 5.0 * GAIN * KP
    rows = {one.name: one for one in found(load=load).stress}
    assert len(rows) == 3  # either way and as a step
    assert {one.holds for one in rows.values()} == {times < 1.0}
    if times > 1.0:
        parts = {one.part for one in rows.values()}
        assert parts == {PARTS[np.argmax(times * PARTS > 1.0)]}
        assert all(one.why.startswith("is far off") for one in rows.values())


@pytest.mark.parametrize(
    ("load", "expected"),
    [
        ({}, 0.1 * 10.0 * GAIN),
        ({"sines": [{"amplitude": 3.0, "frequency_rad_s": 10.0 * np.pi}]}, 3.0),
        ({"constant": -2.0, "sines": [{"amplitude": 3.0, "frequency_rad_s": 30.0}]}, 2.0),
    ],
)
def test_the_load_is_what_a_motion_has_or_what_a_tenth_of_10_v_holds(load, expected):
    scenario = load_scenario(STAGE | {"load": load, "limits": {"command": 10.0}})
    assert loads(scenario) == [pytest.approx(expected)]


def test_it_is_held_where_the_motion_begins():
    scenario = load_scenario(STAGE)
    samples = scenario.samples()
    longer = _load_first(scenario, samples)
    (one,), (other,) = samples.axes, longer.axes
    assert len(longer.time) == 4000
    for name in ("reference", "target", "reference_rate"):
        column = getattr(other, name)
        assert (column[:2000] == 0.0).all()
        np.testing.assert_array_equal(column[2000:], getattr(one, name))
    np.testing.assert_array_equal(longer.late, np.append(np.zeros(2000), samples.late))
    np.testing.assert_array_equal(longer.settled, np.append(np.zeros(2000), samples.settled))


@pytest.mark.parametrize(("share", "machines"), [(0.75, 32), (0.9, 8)])
def test_where_it_is_close_four_times_as_many_machines_decide(share, machines):
    """Two of the first eight amplifiers are too weak for the load, by hand as above."""
    spread = {"amplifier_gain": 0.2}
    robust = STAGE["robust"] | {"tolerances": spread, "unseen": 50}
    scenario = load_scenario({**STAGE, "robust": robust})
    some, _ = drawn(scenario.plant, 1e-6, 50, scenario.run.seed + BEYOND, spread)
    gains = some.actual[0].amplifier_gain
    weak = np.sort(gains[:8])[1:3].mean()
    own = found(robust, load=0.05 * 5.0 * weak * KP, share=share, machines=8)
    (row,) = (one for one in own.stress if one.name.startswith("an extra load of -"))
    assert row.share == np.mean(gains[:machines] > weak)
    assert row.holds == (row.share >= share)


def test_backwards_an_axis_that_goes_harder_stays_behind():
    """Friction is 0.3 of the mean forwards, 1.7 backwards; kp alone holds it."""
    speed, rubs = 50.0, -0.7
    off = 1e-3 * speed * DRAG * (1.0 - rubs) / (GAIN * KP)
    changes = {
        "plant.parameters.viscous_asymmetry": rubs,
        "reference": {"kind": "ramp", "velocity": speed},
        "constraints.late_error": 0.8 * off,
    }
    (row,) = found(changes=changes, backwards=1.0).stress
    assert (row.holds, row.part, row.why) == (False, 0.875, "is far off")
    assert row.breaks == "every motion 87.5 % backwards"
    (row,) = found(changes={**changes, "constraints.late_error": 1.2 * off}, backwards=1.0).stress
    assert row.holds


def test_a_rest_goes_on_where_the_motion_has_ended():
    samples = load_scenario(STAGE).samples()
    longer = _resting(samples, 0.5)
    (one,), (other,) = samples.axes, longer.axes
    assert len(longer.time) == 2500
    assert longer.time[-1] == pytest.approx(2.499)
    assert (other.reference[2000:] == one.reference[-1]).all()
    assert (other.reference_rate[2000:] == 0.0).all()
    np.testing.assert_array_equal(other.reference[:2000], one.reference)
    assert (np.flatnonzero(longer.late)[0], longer.late.max()) == (1875, 2.0)
    assert 0.0 < GOLDEN < 1.0


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"stress.delay_samples": 17}, "stress.delay_samples"),
        ({"stress.noise": 0.5}, "stress.noise"),
        ({"stress.load": "3 kg"}, "stress.load"),
        (
            {"stress.delay_samples": 1, "robust.tolerances": {"delay_samples": 1.0}},
            "stress.delay_samples",
        ),
    ],
)
def test_stress_that_cannot_be_is_a_line(changes, where):
    with pytest.raises(UserError, match=where) as told:
        load_scenario(STAGE, changes)
    assert len(told.value.lines) == 1


def test_where_a_log_shows_no_mode_none_is_tried():
    told = found(mode_inertia=[0.1], unknown_above_hz=200.0).stress
    at = [float(one.name.split()[3]) for one in told]
    assert (min(at), max(at)) == (200.0, 250.0)
    assert sum("before the encoder" in one.name for one in told) == 4
    at_the_drive = found(mode_inertia=[0.1], unknown_above_hz=200.0, encoder_at="drive").stress
    assert [one.name for one in at_the_drive] == [one.name for one in told if "moving" in one.name]
    assert not found(mode_inertia=[0.1], unknown_above_hz=250.0).stress


@pytest.mark.parametrize("times", [0.8, 1.2])
def test_a_load_is_held_as_long_as_the_motion_before_it(times):
    """What an integral leaves of its error after 3.5 s, of a motion of 2 s; 1.5 s are too few."""
    push = np.array([0.0, 1e3 / MASS, 0.0])  # on position [mm], velocity, integral of the position
    spring = -1e3 * GAIN / MASS * KP
    a = np.array([[0, 1, 0], [spring, -(DRAG + 1e3 * GAIN * KD) / MASS, 0.5 * spring], [1, 0, 0]])
    left = np.linalg.solve(a, (expm(3.5 * a) - np.eye(3)) @ push)[0]
    changes = {"constraints.late_error": "0.05 mm", "reference.distance": 1.0}
    rows = found(changes=changes, ki=0.5 * KP, load=times * 0.05 / left).stress
    loaded = [one.holds for one in rows if one.name.startswith("an extra load of")]
    assert loaded == 2 * [times < 1.0]
