"""Tables of the commands in narrow terminals: nothing is wider, and no number is cut."""

import pytest
from click.testing import CliRunner

from hfc_design.cli import main

SPINDLE = "deflection=0.001,deflection_rate=0.01,spindle_velocity=0.02"
AT = f"error=0.001,error_rate=0.1,{SPINDLE},previous_spindle_velocity=0.02"


@pytest.mark.parametrize(
    ("arguments", "numbers"),
    [
        (["explain", "lin-lee-1999-table-1", "--at", AT], ["0.278", "30.83 %", "0.48316"]),
        (["explain", "jee-koren-2004-flc", "--at", "error=12,error_change=1.5"], ["100.00 %"]),
        (["stability", "jee-koren-2004-aflc"], ["0.0242364"]),
    ],
)
def test_no_number_of_a_table_is_cut(arguments, numbers):
    for width in (60, 80, 120):
        done = CliRunner().invoke(main, arguments, env={"COLUMNS": str(width)})
        assert done.exit_code == 0
        assert "…" not in done.stdout
        assert max(map(len, done.stdout.splitlines())) <= width
        words = done.stdout.replace("│", " ").split()
        for number in numbers:
            assert number.split()[0] in words
