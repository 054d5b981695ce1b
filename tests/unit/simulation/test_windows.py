"""Metrics over parts of the motion, against the recorded motion; changed designs."""

import pytest
from click.testing import CliRunner

from hfc_design.cli import main


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.mark.parametrize(
    ("windows", "told"),
    [
        ('[{name="a", from_s=20.0}]', "windows.0: from_s = 20.0, to_s = None hold fewer than two"),
        ('[{name="a", from_s=2.0, to_s=1.0}]', "windows.0: from_s = 2.0, to_s = 1.0 hold fewer"),
        ('[{name="a"}, {name="a", to_s=1.0}]', "windows.0.name = 'a': stands there twice"),
        ('[{name="A b"}]', "windows.0.name = 'A b'"),
        ('[{name="a", to=1.0}]', "windows.0.to"),
    ],
)
def test_windows_that_cannot_be(windows, told):
    found = hfc("score", "pd-only", "--set", f"windows={windows}")
    assert found.exit_code == 2
    assert told in found.stderr
    assert found.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("controller.integral_gain=x", "controller.integral_gain = 'x': has to be a number"),
        ("controller.nope=3", "controller.nope = 3: there is no such key"),
        ("controller.integral_gain.x=2", "integral_gain is not a table"),
        ("nonsense", "--change nonsense: has to look like KEY=VALUE, as in controller.integral"),
        ("plant.name=c-axis", "design jee-koren-2004-flc runs every 0.01 s"),
    ],
)
def test_changes_that_cannot_be(change, told):
    found = hfc("score", "jee-koren-2004-flc", "--change", change)
    assert found.exit_code == 2
    assert told in found.stderr
    assert found.stderr.count("\n") == 1
