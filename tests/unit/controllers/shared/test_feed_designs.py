"""Feed-drive design files: the loop and the runtime agree; what is wrong in one is named."""

import json

import numpy as np
import pytest
from feed_designs import DESIGNS, NAMES, X_AXIS, circle, drive, signals_of
from jk04 import CHANGE_TERMS, ERROR_TERMS, rule_singletons
from wording import refused

from hfc_design.controllers.kinds import KINDS
from hfc_design.files.design import design_json, parse_design
from hfc_design.runtime import Controller


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


@pytest.mark.parametrize("name", NAMES)
def test_built_in_designs_are_as_published(name):
    record = DESIGNS[name].controller
    assert record.kind in KINDS.built_in
    assert parse_design(design_json(DESIGNS[name]), name) == DESIGNS[name]
    gains = record.law_gains()
    if record.kind == "pid":
        assert gains == (1.5, 8.1, 0.1)
        return
    table = gains if record.kind == "flc" else gains.flc
    assert table[:4] == (ERROR_TERMS, CHANGE_TERMS, rule_singletons("I"), 0.0)
    if record.kind != "flc":
        adaptive = {"aflc": (0.5, 0.125, 1.0, 3.0, 0.5), "soflc": (0.5, 0.2, 1.0, 0.5, 0.2)}
        assert gains.rates == adaptive[record.kind]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("error_terms.4.left", 8.0),
        ("error_change_terms.2.right", 0.5),
        ("error_terms.3.right", None),
        ("error_terms.3.label", "PS"),
        ("error_terms", []),
        ("rules.labels.2.1", "BIG"),
        ("rules.labels", [["ZR"] * 7] * 6),
        ("rules.centroids.3", [0.0] * 8),
        ("rules.centroids.3.3", float("inf")),
        ("adaptation.k_b", 2.0),
        ("adaptation.stable_range.k1_max", 0),
        ("low_velocity", {**X_AXIS, "forward": [1.0]}),
    ],
)
def test_design_files_that_cannot_run(key, value):
    data = json.loads(design_json(DESIGNS["jee-koren-2004-aflc"]))
    *keys, last = (int(part) if part.isdigit() else part for part in key.split("."))
    place = data["controller"]
    for part in keys:
        place = place[part]
    place[last] = value
    with refused() as found:
        parse_design(json.dumps(data), "bad.json")
    assert found.where == "bad.json"
    assert "\n" not in found.refusal
