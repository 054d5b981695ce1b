"""The section of the report: the picture of what was learnt is that of the controller."""

import numpy as np
from sliding import sliding
from wording import refused

from hfc_design.controllers.fuzzy_sliding.section import learning
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runtime import Controller


def measured(steps=300):
    k = np.arange(steps)
    return {"error": 20.0 * np.sin(k / 30.0), "error_rate": 300.0 * np.cos(k / 30.0)}


def test_what_is_drawn_is_what_a_controller_learns():
    design, signals = sliding(127.0), measured()
    controller = Controller(design)
    for row in zip(*(values.tolist() for values in signals.values()), strict=True):
        controller.step(dict(zip(signals, row, strict=True)))
    found = learning(controller.adapted(), {k: v[:1] for k, v in signals.items()}, 127.0)
    motion = learning(design.controller, {k: np.append(v, 0.0) for k, v in signals.items()}, 127.0)
    np.testing.assert_array_equal(motion.moves[-1], found.moves[0])
    assert not motion.moves[0].any()


def test_a_machine_without_a_top_speed_needs_a_start():
    own = {"controller": {"kind": "fuzzy-sliding"}, "limits.command": 120.0}
    with refused() as found:
        load_scenario("c-axis-ramp", own)
    assert "controller.start" in found.refusal
