"""What a feed drive takes and reports: converter, encoder, and parameters that are refused."""

import math

from plants import C_AXIS, FEED_DRIVE
from plants.feed_drive import (
    FeedDriveParameters,
)


def test_plants_have_no_speed_limit_and_no_resolution_of_their_own_unless_they_say_so():
    assert FEED_DRIVE.fastest(FeedDriveParameters(), 0.01) == math.inf
    assert C_AXIS.fastest(C_AXIS.parameters(), 1e-3) == math.inf
    x = C_AXIS.initial_state(0.25)
    assert C_AXIS.measured(None, x) is x
    assert C_AXIS.accepted(None, 1234.5) == 1234.5
