"""Machines within tolerances: a Latin hypercube, tolerances of single parameters, seeds."""

import numpy as np
import pytest
from wording import refused, refused_command

from hfc_design.core.records import UserError
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import machines
from hfc_design.simulation.compiled import FEWEST_STEPS, filled_up_steps
from hfc_design.simulation.machines import drawn
from plants import PLANTS, machine_of

C_AXIS, FEED = PlantSettings(), PlantSettings(name="feed-drive")


def shares(some, name):
    """How far a parameter of each machine but the nominal one is from that, as a share of it."""
    (axis,) = some.actual
    values = getattr(axis, name)
    return values[1:] / values[0] - 1.0


def test_a_gap_that_is_a_parameter_is_not_put_before_the_encoder_as_well():
    table, spread = PlantSettings(name="milling-table"), {"backlash": 0.5}
    some, _ = drawn(table, 0.2, 300, 0, spread)
    assert not some.around
    assert 0.45 < abs(shares(some, "backlash")).max() <= 0.5
    assert drawn(FEED, 0.2, 300, 0, spread)[0].around["backlash"].max() > 0.45


def test_a_latin_hypercube_meets_every_part_of_every_range_once():
    some, again = drawn(FEED, 0.2, 50, 3, even=True)
    assert again == 0
    for name in some.actual[0]._fields:
        if getattr(some.actual[0], name)[0] == 0.0 or name in FEED.machine.drives[0].exact:
            continue
        parts = np.floor((shares(some, name) + 0.2) / 0.4 * 50)
        assert sorted(parts) == list(range(50)), name


def test_the_seed_says_what_is_drawn():
    settings = load_scenario("feed-drive-circle").plant
    one, same, other = (drawn(settings, 0.2, 6, seed)[0].actual for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one[0].gain[1:] != other[0].gain[1:]).all()
    more = drawn(settings, 0.2, 9, 1)[0].actual
    np.testing.assert_array_equal(np.array(more)[..., :7], one)


@pytest.mark.parametrize("name", ["feed-drive-circle", "c-axis-ramp"])
def test_drawn_parameters_fill_their_range_and_nothing_else(name):
    settings = load_scenario(name).plant
    true = drawn(settings, 0.2, 200, 3)[0].actual
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
            assert factors.mean() == pytest.approx(1.0, abs=5 * 0.4 / np.sqrt(12 * 200))


def test_parameters_and_axes_are_independent():
    true = drawn(load_scenario("feed-drive-circle").plant, 0.2, 400, 3)[0].actual
    varied = [column[1:] for axis in true for column in axis if np.ptp(column)]
    assert len(varied) == 2 * 8  # gain, time constant, six of the friction
    assert abs(np.corrcoef(varied) - np.eye(16)).max() < 5 / np.sqrt(400)


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_what_is_exact_is_a_parameter(plant):
    for drive in machine_of(plant).drives:
        assert drive.exact < set(drive.parameters._fields)


def test_machines_that_cannot_exist_are_drawn_again_and_counted(monkeypatch):
    settings = load_scenario("c-axis-ramp").plant
    found, refused = drawn(settings, 0.4, 50, 0)
    (p,) = found.actual
    assert (p.stator_inductance * p.rotor_inductance > p.mutual_inductance**2).all()
    assert (p.static_torque >= p.coulomb_torque).all()
    # By the same stream of numbers: every draw that passes is kept, in order.
    varied = [name not in ("poles", "gear_ratio") for name in p._fields]
    stream = np.random.default_rng(0).uniform(0.6, 1.4, (50 + refused, sum(varied)))
    all_of_them = np.array(settings.values()[0])[varied] * stream
    ls, lr, lm, tc, ts = (
        all_of_them[:, [n for n, v in zip(p._fields, varied, strict=True) if v].index(name)]
        for name in (
            "stator_inductance", "rotor_inductance", "mutual_inductance",
            "coulomb_torque", "static_torque",
        )
    )  # fmt: skip
    possible = (ls * lr > lm**2) & (ts >= tc)
    assert refused == 50 + refused - possible.sum() > 0
    np.testing.assert_array_equal(p.mutual_inductance[1:], lm[possible])
    monkeypatch.setattr(machines, "MAX_DRAWS", 0)
    with pytest.raises(UserError, match=r"spread=0.4: only \d+ of \d+ draws gave a possible"):
        drawn(settings, 0.4, 50, 0)


@pytest.mark.parametrize(
    ("key", "where"),
    [(None, "tolerances: mass"), ("robust.spread", "robust.tolerances.mass")],
)
def test_an_unknown_parameter(key, where):
    with refused() as found:
        drawn(C_AXIS, 0.2, 3, 0, {"mass": 0.1}, key=key)
    assert found.refusal.startswith(where)


@pytest.mark.parametrize(
    ("arguments", "where"),
    [
        (["--spread", "0"], "--spread 0.0"),
        (["--spread", "nan"], "--spread nan"),
        (["--spread", "0.2", "--samples", "0"], "--samples 0"),
        (["--samples", "10"], "--samples"),
        (["--plot", "a.png"], "--plot"),
    ],
)
def test_what_is_refused(arguments, where):
    found = refused_command("score", "pd-only", *arguments)
    assert found.startswith(f"hfc: {where}")
    assert found.count("\n") == 1


def test_up_to_a_quarter_more_samples_make_four_lengths_of_an_octave():
    steps = np.arange(1, 16 * FEWEST_STEPS + 1)
    filled = np.array([filled_up_steps(int(one)) for one in steps])
    assert (filled >= steps).all()
    assert (filled - steps <= np.maximum(steps // 4, FEWEST_STEPS - 1)).all()
    for octave in (4, 8):  # from so many of the fewest steps to twice as many
        inside = (steps > octave * FEWEST_STEPS) & (steps <= 2 * octave * FEWEST_STEPS)
        assert len({*filled[inside].tolist()}) == 4


def test_few_records_are_filled_up_so_far_that_motions_of_all_usual_lengths_are_one():
    """By hand: 16,384 samples of one individual are 1 MB for each 8 quantities, of four 4,096."""
    assert {filled_up_steps(steps, 1) for steps in (1, 500, 6000, 16_384)} == {16_384}
    assert {filled_up_steps(steps, 4) for steps in (1, 500, 4096)} == {4096}
    for steps, recorded in ((16_385, 1), (6000, 4), (3000, 1000)):
        assert filled_up_steps(steps, recorded) == filled_up_steps(steps)


def test_a_parameter_has_a_tolerance_of_its_own():
    tolerances = {"stiffness": 0.5, "rotor_inertia": 0.01}
    some, _ = drawn(C_AXIS, 0.2, 300, 0, tolerances)
    widths = {name: abs(shares(some, name)).max() for name in ("stiffness", "rotor_inertia")}
    assert 0.45 < widths["stiffness"] <= 0.5
    assert 0.009 < widths["rotor_inertia"] <= 0.01
    assert 0.18 < abs(shares(some, "spindle_inertia")).max() <= 0.2
    assert (shares(some, "poles") == 0.0).all()


def test_the_first_machines_of_a_seed_stay():
    some, more = (drawn(C_AXIS, 0.2, count, 7)[0] for count in (5, 40))
    for few, many in zip(some.actual[0], more.actual[0], strict=True):
        assert few.tolist() == many[:6].tolist()
