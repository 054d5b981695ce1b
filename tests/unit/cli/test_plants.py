"""What ``hfc list plants`` says of signals and parameters."""

import pytest

from plants import C_AXIS
from plants.milling_table import MILLING_TABLE
from plants.positioning_stage import POSITIONING_STAGE


@pytest.mark.parametrize("drive", [C_AXIS, MILLING_TABLE, POSITIONING_STAGE])
def test_every_parameter_has_a_unit(drive):
    assert [*drive.parameter_units] == [*drive.parameters._fields]
