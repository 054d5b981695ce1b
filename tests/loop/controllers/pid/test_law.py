"""The PID controller: by hand."""

import pytest
from wording import refused

from hfc_design.files.design import design_json
from hfc_design.files.pairing import load_design
from hfc_design.runtime import Controller


def test_an_error_within_the_dead_zone_counts_as_0():
    """By hand: 2, then 1 and -1 as 0, then -3."""
    design = load_design("jee-koren-2004-pid", {"controller.dead_zone": 1.0})
    controller = Controller(design)
    found = [controller.step({"error": error}) for error in (2.0, 1.0, -1.0, -3.0)]
    integral = 8.1 * 0.01
    assert found == pytest.approx(
        [3.0 + 2 * integral + 20.0, 2 * integral - 20.0, 2 * integral, -4.5 - integral - 30.0]
    )


def test_a_design_without_a_dead_zone_does_not_name_it():
    assert "dead_zone" not in design_json(load_design("jee-koren-2004-pid"))
    with refused() as found:
        load_design("jee-koren-2004-pid", {"controller.dead_zone": -1})
    assert "controller.dead_zone = -1" in found.refusal
