"""Windows and changes that cannot be."""

import pytest
from wording import refused_command


@pytest.mark.parametrize(
    ("windows", "where"),
    [
        ('[{name="a", from_s=20.0}]', "windows.0: from_s"),
        ('[{name="a"}, {name="a", to_s=1.0}]', "windows.0.name"),
        ('[{name="a", to=1.0}]', "windows.0.to"),
    ],
)
def test_windows_that_cannot_be(windows, where):
    found = refused_command("score", "pd-only", "--set", f"windows={windows}")
    assert f": {where} = " in found
    assert found.count("\n") == 1


@pytest.mark.parametrize(
    "change",
    [
        "controller.nope=3",
        "controller.integral_gain.x=2",
        "plant.name=c-axis",
    ],
)
def test_changes_that_cannot_be(change):
    found = refused_command("score", "jee-koren-2004-flc", "--change", change)
    assert found.count("\n") == 1
