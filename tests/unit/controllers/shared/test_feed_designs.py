"""Feed-drive design files: the loop and the runtime agree; what is wrong in one is named."""

import json

import made_up
import numpy as np
import pytest
from jk04 import CHANGE_TERMS, ERROR_TERMS, rule_singletons

from hfc_design.controllers.kinds import KINDS
from hfc_design.core import devices
from hfc_design.core.records import UserError
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.pairing import load_design
from hfc_design.runtime import Controller

devices.configure()

NAMES = [
    "jee-koren-2004-pid",
    "jee-koren-2004-flc",
    "jee-koren-2004-aflc",
    "jee-koren-1995-soflc",
]
X_AXIS = {
    "forward": [0.05, -1.16, 6.54],
    "backward": [-0.04, -1.0, -6.43],
    "highest_velocity_mm_s": 12.0,
    "breakaway": [6.54, -6.43],
    "smallest_error": 2.0,
}


def changed(name, **controller):
    """A built-in design with keys of its controller replaced."""
    data = json.loads(design_json(load_design(name)))
    data["controller"] |= controller
    return parse_design(json.dumps(data), "mine.json")


DESIGNS = {name: load_design(name) for name in NAMES}
for kind in ("2004-flc", "2004-aflc", "1995-soflc"):
    DESIGNS[f"{kind} with all terms"] = changed(
        f"jee-koren-{kind}", integral_gain=8.0, low_velocity=X_AXIS
    )
DESIGNS["2004-aflc with options"] = made_up.with_options("aflc", 5)
DESIGNS["pid with a dead zone"] = changed("jee-koren-2004-pid", dead_zone=1.0)
for form in ("P", "PI"):
    DESIGNS[f"flc {form}"] = changed("jee-koren-2004-flc", form=form)


def circle(count=600):
    """Reference of a circle's axis in whole BLU."""
    return np.rint(1000.0 * (1 - np.cos(2 * np.pi * np.arange(count) / 400))).tolist()


def drive(position, velocity, command):
    """A drive of gain 28.3 and 55 ms under a held command, in 10 ms."""
    velocity = velocity + 0.01 / 0.055 * (28.3 * command - velocity)
    return position + 0.01 * velocity, velocity


def signals_of(position, velocity, reference, floor):
    return {"error": reference - floor(position + 0.5), "velocity": velocity, "position": position}


def test_the_aflc_follows_better_each_turn():
    turns = circle(1200)
    error = {}
    for kind in ("flc", "aflc"):
        controller = Controller(DESIGNS[f"jee-koren-2004-{kind}"])
        position = velocity = 0.0
        errors = []
        for reference in turns:
            signals = signals_of(position, velocity, reference, np.floor)
            errors.append(signals["error"])
            command = float(np.clip(controller.step(signals), -128, 127))
            position, velocity = drive(position, velocity, command)
        error[kind] = np.sqrt(np.mean(np.reshape(errors, (3, 400)) ** 2, axis=1))
    assert error["aflc"][2] < error["aflc"][0] < error["flc"][0]


def test_reset_forgets_what_was_learned():
    controller = Controller(DESIGNS["jee-koren-2004-aflc"])
    errors = [3.0, 9.0, 15.0, 20.0, 12.0, 6.0]
    first = [controller.step({"error": e}) for e in errors]
    assert [controller.step({"error": e}) for e in errors] != first
    controller.reset()
    assert [controller.step({"error": e}) for e in errors] == first


@pytest.mark.parametrize("name", NAMES)
def test_built_in_designs_are_as_published(name):
    record = DESIGNS[name].controller
    assert record.kind in KINDS.built_in
    assert parse_design(design_json(DESIGNS[name]), name) == DESIGNS[name]
    gains = KINDS.get(record.kind).gains(record)
    if record.kind == "pid":
        assert gains == (1.5, 8.1, 0.1)
        return
    table = gains if record.kind == "flc" else gains.flc
    assert table[:4] == (ERROR_TERMS, CHANGE_TERMS, rule_singletons("I"), 0.0)
    if record.kind != "flc":
        adaptive = {"aflc": (0.5, 0.125, 1.0, 3.0, 0.5), "soflc": (0.5, 0.2, 1.0, 0.5, 0.2)}
        assert gains.rates == adaptive[record.kind]


def broken(*keys, value):
    data = json.loads(design_json(DESIGNS["jee-koren-2004-aflc"]))
    place = data["controller"]
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    return json.dumps(data)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (broken("error_terms", 4, "left", value=8.0), ["error_terms", "PS", "rise"]),
        (broken("error_terms", 4, "left", value=5.0), ["error_terms", "gap", "ZR", "PS"]),
        (broken("error_terms", 4, "left", value=-1.0), ["error_terms", "ZR", "centre"]),
        (broken("error_change_terms", 2, "right", value=0.5), ["error_change_terms", "centre"]),
        (broken("error_terms", 0, "left", value=-30.0), ["error_terms", "NL", "null"]),
        (broken("error_terms", 3, "right", value=None), ["error_terms", "ZR", "null"]),
        (broken("error_terms", 3, "label", value="PS"), ["error_terms", "NL, NM"]),
        (
            broken("error_terms", 3, "label", value="X X"),
            ["error_terms", "'X X'", "32 letters"],
        ),
        (broken("error_terms", value=[]), ["error_terms", "at least 7"]),
        (broken("rules", "labels", 2, 1, value="BIG"), ["rules.labels.2.1 = 'BIG'", "NL, NM"]),
        (broken("rules", "labels", value=[["ZR"] * 7] * 6), ["rules.labels", "centroids, 7 x 7"]),
        (
            broken("rules", "centroids", 3, value=[0.0] * 8),
            ["rules.centroids.3: has 8 entr"],
        ),
        (
            broken("rules", "centroids", 6, value=[0.0] * 5),
            ["rules.centroids.6: has 5 entr"],
        ),
        (broken("rules", "centroids", value=[[0.0] * 7] * 6), ["rules.labels", "centroids, 6 x 7"]),
        (broken("rules", "centroids", 3, 3, value=float("inf")), ["Infinity"]),
        (broken("integral_gain", value="much"), ["controller.integral_gain = 'much'"]),
        (broken("adaptation", "k_a", value=-0.5), ["adaptation.k_a = -0.5"]),
        (broken("adaptation", "k_b", value=2.0), ["adaptation.k_b = 2.0", "less than 1.5"]),
        (broken("adaptation", "stable_range", "k1_max", value=0), ["k1_max = 0", "greater"]),
        (
            broken("adaptation", "smallest_overlap", "error_change", value=2.0),
            ["adaptation.smallest_overlap.error_change = 2.0", "at most 1.5"],
        ),
        (broken("adaptation", "smallest_overlap", "error", value=0.0), ["error = 0.0", "greater"]),
        (broken("low_velocity", value={**X_AXIS, "forward": [1.0]}), ["low_velocity.forward"]),
        (broken("form", value="PD"), ["controller.form", "no such key"]),
    ],
)
def test_design_files_that_cannot_run(text, words):
    with pytest.raises(UserError) as caught:
        parse_design(text, "bad.json")
    for word in ["bad.json", *words]:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)
