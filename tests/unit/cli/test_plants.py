"""What ``hfc list plants`` says of signals and parameters."""

import pytest
from run_folders import hfc

from plants import C_AXIS, FEED_DRIVE
from plants.milling_table import MILLING_TABLE
from plants.positioning_stage import POSITIONING_STAGE


def test_parameters_stand_with_defaults_and_units():
    done = hfc("list", "plants")
    assert done.exit_code == 0, done.output
    assert max(map(len, done.stdout.splitlines())) <= 80
    rows = [line.strip().split(maxsplit=2) for line in done.stdout.splitlines()]
    assert ["spindle_inertia", "5.102", "kg m2"] in rows
    assert ["gain", "28.3", "(BLU/s)/unit"] in rows
    text = " ".join(done.stdout.split())
    assert "error [rad], error_rate [rad/s], command [V], load [N m], deflection [rad]" in text
    assert "error [BLU], error_rate [BLU/s], command [unit]" in text


@pytest.mark.parametrize("drive", [C_AXIS, FEED_DRIVE, MILLING_TABLE, POSITIONING_STAGE])
def test_every_parameter_has_a_unit(drive):
    assert [*drive.parameter_units] == [*drive.parameters._fields]
