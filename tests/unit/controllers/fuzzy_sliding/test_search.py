"""The genome: it begins with the start, keeps to its ranges, and is the design that it writes."""

import pytest

from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario

CIRCLE = {"controller": {"kind": "fuzzy-sliding"}, "limits.command": 120.0}


def test_a_machine_without_a_top_speed_needs_a_start():
    with pytest.raises(UserError, match=r"start: is missing; without one limits\.command and"):
        load_scenario("c-axis-ramp", CIRCLE)
