"""Servo axes of the five-axis machines against hand calculations and SciPy, and their coupling."""

import pytest

from hfc_design.files.design import named_design
from plants import PLANTS

MACHINE, COUPLED = PLANTS["five-axis"], PLANTS["five-axis-coupled"]
DRIVES = dict(zip(MACHINE.axes, MACHINE.drives, strict=True))


def test_printed_gains_are_a_speed_over_an_error():
    """Table 1: the largest error, 15 mm of X and 10 deg of A, asks for 8 V, the largest voltage."""
    gains = named_design("lin-gai-2009-pid").controller.axes
    assert gains["x"].pid.k_p * 15.0 == pytest.approx(8.0, rel=2e-4)
    assert gains["a"].pid.k_p * 10.0 == pytest.approx(8.0, rel=2e-4)
    for axis, own in gains.items():
        per_volt = DRIVES[axis].parameters().velocity_per_volt
        wanted = (33.33 / per_volt, 0.1 / per_volt, 0.01 / per_volt)
        assert tuple(dict(own.pid).values()) == pytest.approx(wanted)
