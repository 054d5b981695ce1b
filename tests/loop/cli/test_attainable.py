"""``hfc attainable``, and what a run tells of it: in the terminal, its folder, its page."""

import pytest
from click.testing import CliRunner

from hfc_design.cli import main

SHORT = ["--set", "simulation.duration_s=0.3", "--set", "limits.command=250"]


def hfc(*told):
    return CliRunner().invoke(main, told)


@pytest.mark.parametrize(
    ("told", "why"),
    [
        (["c-axis-ramp"], "has no limits.command"),
        (["feed-drive-circle"], "bounds are of machines of one c-axis only"),
        (["nowhere"], "nowhere: no such scenario"),
        (["c-axis-ramp", *SHORT, "--design", "jee-koren-2004-pid"], "jee-koren-2004-pid"),
    ],
)
def test_bad_input_is_one_line(told, why):
    result = hfc("attainable", *told)
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert line.startswith("hfc: ")
    assert why in line
