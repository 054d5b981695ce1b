"""What the files of users say is read within limits; what is wrong is told in a line."""

import pytest

from hfc_design.core.records import LONGEST, UserError
from hfc_design.files.named_scenario import load_scenario


def refused(read, *arguments):
    with pytest.raises(UserError) as caught:
        read(*arguments)
    line = str(caught.value)
    assert len(line) <= LONGEST == 520
    assert line.isprintable()
    return line


@pytest.mark.parametrize(
    ("scenario", "change"),
    [
        ("c-axis-ramp", "velocity=1e308"),
        ("c-axis-ramp", "velocity=-1e308"),
        ("feed-drive-circle", "radius_mm=1e308"),
        ("feed-drive-circle", "cycles=1e308"),
        ("feed-drive-circle", "feed_mm_min=5e-324"),
    ],
)
def test_motions_beyond_all_numbers(scenario, change):
    assert "what numbers can hold" in refused(load_scenario, scenario, [f"reference.{change}"])
