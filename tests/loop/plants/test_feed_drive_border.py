"""What a feed drive takes and reports: converter, encoder, and parameters that are refused."""

import pytest
from jk04 import PARAMETER_SETS

from hfc_design.files.machine import PlantSettings
from plants import FEED_DRIVE
from plants.feed_drive import (
    FeedDriveParameters,
    FeedDriveState,
    accepted,
    coefficients,
)


def test_converter_takes_whole_units_within_its_limits():
    c = coefficients(FeedDriveParameters())
    for command, wanted in (
        (0.4, 0.0), (0.6, 1.0), (-0.6, -1.0), (12.49, 12.0), (-12.51, -13.0),
        (126.6, 127.0), (127.4, 127.0), (900.0, 127.0), (-127.7, -128.0), (-900.0, -128.0),
    ):  # fmt: skip
        assert accepted(c, command) == wanted
    narrow = coefficients(FeedDriveParameters(lowest_command=-20.0, highest_command=30.0))
    assert (accepted(narrow, -50.0), accepted(narrow, 50.0)) == (-20.0, 30.0)


def test_encoder_reports_whole_units_and_leaves_the_velocity():
    c = coefficients(FeedDriveParameters())
    for position, wanted in ((0.4, 0.0), (0.6, 1.0), (-0.6, -1.0), (4000.49, 4000.0)):
        assert FEED_DRIVE.measured(c, FeedDriveState(position, 12.3)) == (wanted, 12.3)
    assert FEED_DRIVE.signals(c, FeedDriveState(2.0, 3.0)) == {"position": 2.0, "velocity": 3.0}
    units = {"error": "BLU", "error_rate": "BLU/s", "command": "unit", "load": "unit"}
    assert {**units, "position": "BLU", "velocity": "BLU/s"} == FEED_DRIVE.units


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"gain": 0.0}, "parameters.gain = 0.0: has to be more than zero"),
        ({"time_constant": -1.0}, "parameters.time_constant = -1.0: has to be more than zero"),
        ({"coulomb": -1.0}, "parameters.coulomb = -1.0: has to be zero or more"),
        ({"negative_start": 6.4}, "parameters.negative_start = 6.4: has to be zero or less"),
        ({"lowest_command": 0.0}, "parameters.lowest_command = 0.0: has to be less than zero"),
        ({"mass": 1.0}, "parameters.mass: unknown; there is gain, time_constant, coulomb"),
        (
            {"positive_slope": -9.0},
            "parameters.positive_slope = -9.0: with positive_curvature = 0.05 friction",
        ),
        ({"negative_slope": -8.0}, "curvature = -0.04 friction would drive the axis at -12 mm/s"),
        ({"positive_slope": -1e300}, "parameters.positive_slope = -1e+300: with"),
        ({"gain": float("nan")}, "parameters.gain = nan: has to be more than zero"),
    ],
)
def test_impossible_axis_is_named(changes, message):
    assert message in FEED_DRIVE.fault(changes)
    with pytest.raises(ValueError, match="parameters"):
        PlantSettings(name="feed-drive", parameters=changes)


def test_every_named_set_is_possible():
    for parameters in PARAMETER_SETS.values():
        assert FEED_DRIVE.fault(parameters._asdict()) is None
