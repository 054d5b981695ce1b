"""Which observers are tried, what they are told apart by, and logs of other machines."""

import numpy as np

from hfc_design.identify.checks import beyond
from hfc_design.identify.fit import Fit
from hfc_design.identify.free import free
from plants.positioning_stage import POSITIONING_STAGE

WAVE = np.sin(0.05 * np.arange(4000))


def test_commands_that_the_drive_does_not_take_are_told():
    """Two of five are beyond the amplifier's 2 V; one at the limit is not."""
    wanted = free(POSITIONING_STAGE, {"highest_voltage": 2.0}, ("mass",))
    fit = Fit(wanted, wanted.begun, *[WAVE] * 3, 1)
    (line,) = beyond(fit, np.array([-2.5, -2.0, 0.0, 1.0, 7.0]))
    assert line.startswith("40 % of the commands are beyond the -2 to 2 V that the drive takes")
    assert not beyond(fit, np.array([-2.0, 0.0, 2.0]))
