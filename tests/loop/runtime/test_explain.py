"""What an explanation says: by hand, and as the runtime steps."""

import feed_oracle
import jax
import numpy as np
import pytest
from by_name import explanation, random_design, replayed
from exported import with_controller
from feed_designs import DESIGNS, five, jax_motion, runtime_motion
from lifted import controller_of
from wording import refused, refused_command

from hfc_design.controllers.flc.record import CompensationRecord
from hfc_design.controllers.hierarchical.root import Adaptation
from hfc_design.files.design import builtin_designs
from hfc_design.files.loop_setup import load_design
from hfc_design.runtime import Controller

WITH_RULES = [name for name in builtin_designs() if load_design(name).kind.explain]


def changed(name, **update):
    return with_controller(load_design(name), **update)


def read_signals(design):
    """Signals of a sample, and those of the sample before."""
    return design.kind.explain.signals(design.controller)


def text_of(sample):
    return ",".join(f"{name}={value!r}" for name, value in sample.items())


def test_a_feed_drive_by_hand():
    """JK04 Tables 1 and 3: e = 10 is 0.4 PS and 0.2 PM, de = 0.75 is 0.25 ZR and 0.25 PS."""
    low = CompensationRecord(
        forward=(0.04, -1.0, 6.0),
        backward=(0.0, 0.0, 0.0),
        highest_velocity_mm_s=12.0,
        breakaway=(7.0, -7.0),
        smallest_error=2.0,
    )
    design = changed("jee-koren-2004-flc", integral_gain=3.0, low_velocity=low)
    found = explanation(design, ["error=10,error_change=0.75,velocity=500"])
    (unit,) = found["units"]
    fired = {
        side: {k: v for k, v in unit[side]["degrees"].items() if v} for side in ("row", "column")
    }
    assert fired["row"] == pytest.approx({"PS": 0.4, "PM": 0.2})
    assert fired["column"] == pytest.approx({"ZR": 0.25, "PS": 0.25})
    rules = [(r["row"], r["column"], r["consequent"], r["share"]) for r in unit["rules"]]
    third, sixth = pytest.approx(1 / 3), pytest.approx(1 / 6)
    assert sorted(rules[:2]) == [("PS", "PS", 16.0, third), ("PS", "ZR", 8.0, third)]
    assert sorted(rules[2:]) == [("PM", "PS", 16.0, sixth), ("PM", "ZR", 16.0, sixth)]
    fuzzy = (8 + 16) / 3 + (16 + 16) / 6
    assert unit["output"] == pytest.approx(fuzzy)
    compensation = 0.04 * 25 - 5 + 6  # 500 BLU/s are 5 mm/s
    assert found["parts"] == pytest.approx(
        {"fuzzy": fuzzy, "integral": 3.0 * 0.01 * 10.0, "compensation": compensation}
    )
    assert found["command"] == pytest.approx(40 / 3 + 0.3 + 2.0)  # 15.63
    assert found["accepted"] == 16.0
    assert found["command_unit"] == "unit"


@pytest.mark.parametrize("name", WITH_RULES)
def test_the_command_is_the_runtimes_bit_for_bit(name):
    design = load_design(name)
    if design.controller.kind == "pd+hierarchical-fuzzy":
        design = changed(name, adaptation=Adaptation(largest_move=0.5, k_c=0.1))
    now, _ = read_signals(design)
    size = {"feed-drive": 20.0, "milling-table": 0.2}.get(design.plant.name, 0.02)
    random = np.random.default_rng(3)
    samples = [
        dict(zip(now, row, strict=True)) for row in random.normal(0, size, (6, len(now))).tolist()
    ]
    runtime = Controller(design)
    commands = [runtime.step(sample) for sample in samples]
    for k in range(2, 7):
        found = explanation(design, [text_of(sample) for sample in samples[:k]])
        assert found["command"] == commands[k - 1]
        assert sum(found["parts"].values()) == pytest.approx(found["command"], abs=1e-12)
        for unit in found["units"]:
            mean = sum(rule["share"] * rule["consequent"] for rule in unit["rules"])
            assert mean == pytest.approx(unit["output"], abs=1e-12)


def test_the_forms_p_and_pi_of_jk95():
    """P reads no change; PI adds up what is inferred, from 0 before the first sample."""
    p = explanation(changed("jee-koren-2004-flc", form="P"), ["error=10"])
    change = {
        label: degree for label, degree in p["units"][0]["column"]["degrees"].items() if degree
    }
    assert change == {"ZR": 1.0}
    assert p["command"] == pytest.approx((0.4 * 8 + 0.2 * 16) / 0.6)
    pi = changed("jee-koren-2004-flc", form="PI")
    twice = explanation(pi, ["error=7", "error=7"])
    assert twice["units"][0]["output"] == 8.0  # PS and no change
    assert twice["parts"]["fuzzy"] == 8.0 + 8.0  # a first sample has no change either
    assert explanation(pi, ["error=7,error_change=0"])["parts"]["fuzzy"] == 8.0


FLC, TABLE_1 = "jee-koren-2004-flc", "lin-lee-1999-table-1"
MISTAKES = [
    (FLC, "error=1"),
    (FLC, "error=1,speed=2"),
    (FLC, "error=1,error=2"),
    (FLC, "error=1,error_change=1,previous_error=0"),
    (FLC, "error=1", "error=1,previous_error=0"),
    (FLC, "error=nan"),
    (FLC, "error"),
    (FLC, ""),
    (TABLE_1, "error=1"),
    (TABLE_1, "error_change=1"),
    ("pd-only", "error=1"),
    ("jee-koren-2004-pid", "error=1"),
]


def test_mistakes_are_one_line():
    for name, *samples in MISTAKES:
        with refused():
            explanation(load_design(name), samples)
        at = (part for sample in samples for part in ("--at", sample))
        assert refused_command("explain", name, *at).count("\n") == 1


def test_what_is_not_finite_is_a_line_of_at():
    rest = "error_rate=0,deflection_rate=0,spindle_velocity=0,previous_spindle_velocity=0"
    for name, at in (
        (FLC, "error=nan,error_change=1"),
        (FLC, "error=1e308,error_change=-1e308"),
        (FLC, "error=1e999,error_change=0"),
        (TABLE_1, f"error=1e308,deflection=0,{rest}"),
        (TABLE_1, f"error=0,deflection=1e308,{rest}"),
    ):
        lines = {refused_command("explain", name, "--at", at, *json) for json in ((), ("--json",))}
        (line,) = lines
        assert line.count("\n") == 1
        assert "--at" in line


def equals_the_loop(design, scenario):
    compiled, found = replayed(design, scenario)
    np.testing.assert_allclose(found, compiled, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("scenario", ["c-axis-ramp", "c-axis-ramp-cutting"])
@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "pd-only"])
def test_equals_the_loop_on_built_in_designs(name, scenario):
    equals_the_loop(load_design(name), scenario)


def test_equals_the_loop_on_random_designs(random_population):
    for seed in range(3):
        equals_the_loop(random_design(6, seed, random_population), "c-axis-ramp-cutting")


@pytest.fixture(scope="module")
def rough():
    """A rough reference, and five individuals of which the first is the design."""
    design = DESIGNS["jee-koren-2004-aflc"]
    controller, one = controller_of(design)
    random = np.random.default_rng(3)

    def varied(leaf):
        factors = random.uniform(0.95, 1.05, (1,) * (leaf.ndim - 1) + (5,))
        factors[..., 0] = 1.0
        return leaf * factors

    reference = feed_oracle.errors(600, 3)
    many = jax.tree.map(varied, one)
    return design, controller, many, reference, jax_motion(controller, many, reference)


def test_the_loop_equals_the_runtime_on_a_rough_reference(rough):
    design, _, _, reference, found = rough
    expected = list(runtime_motion(design, reference))
    np.testing.assert_allclose(found[:, 0], expected, rtol=1e-12, atol=1e-12)


def test_a_population_equals_its_individuals(rough):
    _, controller, many, reference, together = rough
    assert np.ptp(together[-1]) > 0.1
    for k in range(5):
        own = jax.tree.map(lambda leaf, k=k: leaf[..., k : k + 1], many)
        alone = jax_motion(controller, five(own), reference)
        np.testing.assert_allclose(together[:, k], alone[:, 0], rtol=1e-12, atol=1e-12)
