"""One design on machines that differ: each against its own run, stability against its poles."""

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import machines
from hfc_design.simulation.monte_carlo import drawn
from plants import PLANTS, machine_of


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_what_is_exact_is_a_parameter(plant):
    for drive in machine_of(plant).drives:
        assert drive.exact < set(drive.parameters._fields)


def test_machines_that_cannot_exist_are_drawn_again_and_counted(monkeypatch):
    settings = load_scenario("c-axis-ramp").plant
    found, refused = drawn(settings, 0.4, 50, 0)
    (p,) = found.true
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
    with pytest.raises(UserError, match=r"spread=0.4: of \d+ draws only \d+ gave a possible"):
        drawn(settings, 0.4, 50, 0)


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--spread", "0"], ["--spread 0.0", "between 0 and 1"]),
        (["--spread", "1"], ["--spread 1.0", "between 0 and 1"]),
        (["--spread", "-0.2"], ["--spread -0.2"]),
        (["--spread", "nan"], ["--spread nan"]),
        (["--spread", "0.2", "--samples", "0"], ["--samples 0", "between 1 and"]),
        (["--spread", "0.2", "--seed", "-1"], ["--seed -1"]),
        (["--samples", "10"], ["--samples needs --spread"]),
        (["--seed", "1"], ["--seed needs --spread"]),
        (["--plot", "a.png"], ["--plot needs --spread"]),
    ],
)
def test_what_is_refused(arguments, words):
    done = hfc("score", "pd-only", *arguments)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert done.stderr.startswith("hfc: ")
    assert done.stderr.count("\n") == 1
    for word in words:
        assert word in done.stderr
