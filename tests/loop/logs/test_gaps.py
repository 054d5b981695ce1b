"""Columns that are missing in a log, and what is said of them."""

import re

import numpy as np
from wording import refused

from hfc_design.logs.columns import Log, parse_columns
from hfc_design.logs.signals import signals
from plants import PLANTS

STAGE = PLANTS["positioning-stage"]
TIME = np.arange(400) * 1e-3
PLACE = 3.0 * np.sin(20 * TIME)  # [mm]
VOLTS = np.sin(20 * TIME + 1)


def found(columns, *told):
    return signals(Log(columns), STAGE, parse_columns(told, STAGE), None)


def test_all_gaps_are_told_at_once_with_the_options_that_fill_them():
    """A scope's names: what the line says is taken, and 100 % are the amplifier's 10 V."""
    columns = {"TIME [ms]": 1e3 * TIME, "Actual position [mm]": PLACE, "Set position [mm]": PLACE}
    columns["Torque command [%]"] = 10.0 * VOLTS
    with refused(ValueError) as refusal:
        found(columns)
    one = found(columns, *re.findall(r'--column "(.*?)"', str(refusal.error)))
    np.testing.assert_allclose(one.values["command"], VOLTS, atol=1e-12)
    np.testing.assert_allclose(one.values["position"], PLACE, atol=1e-12)
    assert "reference" in one.values
    with refused(ValueError):
        found(columns, "position=actual position", "command=torque command")
