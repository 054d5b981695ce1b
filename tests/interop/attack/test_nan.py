"""Readings that are not finite, and far too large ones, in every kind: Python, C, Structured Text.

The oracle is the same controller stepped without the faulty samples: its commands at the good ones
have to be the same bit for bit. That C and Structured Text take the same samples for faulty and
give the same commands is compared with the runtime.
"""

import sys
from itertools import product
from math import inf, nan

import made_up
import numpy as np
import pytest
from attack import SEED, Attack, rounds
from c_program import built, commands
from places import OWN_PARTS
from structured_text import FunctionBlock

from hfc_design.core.numbers import finite
from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.st import text_of
from hfc_design.runtime import Controller, use

OWN = OWN_PARTS
ODD = (nan, inf, -inf)
HUGE = (1e308, -1e308, 1.7e308, -1.7e308, 1e155, -1e155, 1e30, 5e-324, -0.0)
SAMPLES = 80  # of a run
LIMITS = (None, 20.0, 1e3)


def gains(plant, kind, every, **ranges):
    def design(seed):
        random = np.random.default_rng(seed)
        own = {name: float(random.uniform(low, high)) for name, (low, high) in ranges.items()}
        own = {name: 0.0 if random.random() < 0.1 else gain for name, gain in own.items()}
        return made_up._design(plant, kind=kind, sample_time_s=every, **{kind: own})

    return design


def fuzzy(kind):
    def design(seed):
        random = np.random.default_rng(seed)
        changes = {"integral_gain": float(random.choice([0.0, 0.1, 50.0]))}
        if random.random() < 0.5:
            changes["low_velocity"] = None
        if kind == "flc":
            changes["form"] = str(random.choice(["P", "PI", "PD"]))
        return made_up.fuzzy(kind, seed, **changes)

    return design


def hierarchy(**changes):
    return lambda seed: made_up.hierarchy(seed, 2 + seed % 5, **changes)


def toy(seed):
    random = np.random.default_rng(seed)
    return made_up._design(
        "toy-machine",
        kind="toy",
        sample_time_s=0.001,
        heights=np.sort(random.uniform(-9.0, 9.0, 5)).tolist(),
        width=float(random.uniform(0.1, 3.0)),
        integral=float(random.uniform(0.0, 30.0)),
        rate=float(random.choice([0.0, 0.1, 20.0])),
    )


ADAPTATION = {"k_c": 1e-2, "largest_move": 0.5, "error_scale": 3.0}
KIND_OF = {
    "pd": gains("c-axis", "pd", 0.001, kp=(-500.0, 5000.0), kd=(-30.0, 300.0)),
    "pid": gains("feed-drive", "pid", 0.01, k_p=(-1.0, 20.0), k_i=(-1.0, 50.0), k_d=(0.0, 1.0)),
    "neural": lambda seed: made_up.network(seed, 1 + seed % 5),
    "pid+ff": lambda seed: made_up.linear("pid+ff", seed),
    "lqi": lambda seed: made_up.linear("lqi", seed, "feed-drive"),
    "flc": fuzzy("flc"),
    "aflc": fuzzy("aflc"),
    "soflc": fuzzy("soflc"),
    "hierarchy": hierarchy(),
    "adapting hierarchy": hierarchy(adaptation=ADAPTATION),
    "hierarchy on a linear part": lambda seed: made_up.hierarchy_on_linear(seed, 2 + seed % 5),
    "adapting hierarchy on a linear part": lambda seed: made_up.hierarchy_on_linear(
        seed, 2 + seed % 5, adaptation=ADAPTATION
    ),
    "hierarchy that schedules": lambda seed: made_up.scheduling(seed, 2 + seed % 5),
    "adapting hierarchy that schedules": lambda seed: made_up.scheduling(
        seed, 2 + seed % 5, adaptation=ADAPTATION
    ),
    "toy": toy,
}


@pytest.fixture(params=KIND_OF)
def kind(request, own_plugins):
    """Name of a kind, and its designs by a seed."""
    if request.param == "toy":
        sys.path.insert(0, str(OWN))
        use("toy_kind:KIND")
    make = KIND_OF[request.param]

    def design(seed):
        limit = LIMITS[np.random.default_rng(seed).integers(3)]
        limits = {"command": limit} if limit else {}
        return Design.model_validate(make(seed).model_dump(mode="json") | {"limits": limits})

    return request.param, design


def wandering(design, random, count):
    """(count, signals) all over the universe and beyond, with jumps, rests and whole numbers."""
    names = list(code.signals(design))
    reach = {"error": 25.0, "velocity": 900.0} if design.plant.name == "feed-drive" else {}
    scale = np.array([reach.get(name, 1.5) for name in names])
    walk = np.cumsum(random.normal(0.0, 0.1, (count, len(names))), axis=0)
    found = scale * np.sin(walk) + 0.02 * scale * random.normal(size=walk.shape)
    found[random.random(count) < 0.05] *= 3.0
    found[random.random(count) < 0.1] = 0.0
    return np.where(random.random((count, 1)) < 0.3, np.round(found), found)


def mixed(samples, random, odd, share=0.1):
    """The samples with each of ``odd`` in every signal in turn, then at random places."""
    found = samples.copy()
    turns = list(product(range(samples.shape[1]), odd))
    places = random.choice(len(samples), min(len(turns), len(samples)), replace=False)
    for place, (signal, value) in zip(places, turns, strict=False):
        found[place, signal] = value
    hit = (random.random(len(samples)) < share)[:, None] & (random.random(samples.shape) < 0.5)
    return np.where(hit, random.choice(odd, samples.shape), found)


def stepped(controller, names, samples):
    rows = (dict(zip(names, row, strict=True)) for row in samples.tolist())
    return np.array([controller.step(row) for row in rows])


def agree(found, expected, tolerance):
    """The same samples are faulty, the commands the same to rounding of the largest so far."""
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    scale = np.maximum.accumulate(np.nan_to_num(np.abs(expected)))
    off = np.abs(np.nan_to_num(found) - np.nan_to_num(expected))
    assert (off <= tolerance * np.maximum(scale, 1.0)).all(), off.max()


def stepped_alike(design, samples, folder, readings_alone):
    """What the runtime, C and Structured Text make of the samples."""
    names = list(code.signals(design))
    controller = Controller(design)
    expected = stepped(controller, names, samples)
    faulty = np.isnan(expected)
    assert not (np.isfinite(expected) & ~np.isfinite(samples).all(axis=1)).any()
    if readings_alone:
        np.testing.assert_array_equal(faulty, ~np.isfinite(samples).all(axis=1))
    alone = Controller(design)
    np.testing.assert_array_equal(expected[~faulty], stepped(alone, names, samples[~faulty]))
    assert repr(controller._memory) == repr(alone._memory)
    agree(commands(folder / "program", samples), expected, 1e-11)
    block = FunctionBlock(text_of(design))
    pairs = []
    for row in samples.tolist():
        command = block.step(**dict(zip(names, row, strict=True)))
        assert command == 0.0 or not block.values["fault"]
        pairs.append(nan if block.values["fault"] else command)
    agree(np.array(pairs), stepped(Controller(design), names, samples), 1e-11)


def in_float(program, samples, random):
    """Single precision overflows elsewhere; what it takes for faulty leaves nothing behind too."""
    huge = (3.4e38, -3.4e38, 1e30, 1e-45)
    samples = mixed(samples, random, (*ODD, *huge)).astype(np.float32)
    found = commands(program, samples, np.float32)
    good = ~np.isnan(found)
    assert not np.isinf(found).any()
    assert np.isfinite(samples[good]).all()
    np.testing.assert_array_equal(found[good], commands(program, samples[good], np.float32))


def test_a_faulty_sample_is_as_if_it_had_not_been(kind, tmp_path):
    name, design_of = kind
    attack = Attack(f"NaN and infinity, {name}")

    for seed in range(rounds(2, 200)):  # compilers and all: no single inputs, which have 10 s
        random = np.random.default_rng([SEED, seed])
        design, folder = design_of(1000 * SEED + seed), tmp_path / str(seed)
        built("gcc", design, folder)
        samples = wandering(design, random, SAMPLES)
        with np.errstate(all="ignore"):
            stepped_alike(design, mixed(samples, random, ODD), folder, True)
            stepped_alike(design, mixed(samples, random, (*ODD, *HUGE)), folder, False)
            if seed % 4 == 0:
                in_float(built("gcc", design, folder / "float", "-DHFC_FLOAT"), samples, random)
        attack.outcomes["equal"] += 1
    attack.end(samples=2 * SAMPLES * attack.outcomes.total())


def test_a_soak(kind, tmp_path):
    """Python and C for long, the memory finite all the way."""
    name, design_of = kind
    attack = Attack(f"soak, {name}")
    random, count = np.random.default_rng([SEED, 1]), 1000
    design = design_of(SEED + 7)
    names = list(code.signals(design))
    program = built("gcc", design, tmp_path / "c")
    controller, seen, told = Controller(design), [], []

    for _ in range(rounds(2, 1000)):
        samples = mixed(wandering(design, random, count), random, (*ODD, 1e12, -1e12, 5e-324))
        seen.append(samples)
        told.append(stepped(controller, names, samples))
        assert finite(controller._memory)
        attack.outcomes["finite"] += 1
    samples, expected = np.concatenate(seen), np.concatenate(told)
    faulty = ~np.isfinite(samples).all(axis=1)
    np.testing.assert_array_equal(np.isnan(expected), faulty)
    found = commands(program, samples)
    agree(found, expected, 1e-9)
    off = np.nan_to_num(np.abs(found - expected))
    attack.end(samples=len(samples), faulty=int(faulty.sum()), largest_difference=float(off.max()))
