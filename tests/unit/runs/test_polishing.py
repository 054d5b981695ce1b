"""A polished run: what it brings, that no interruption changes it, and what is refused."""

import pytest

from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario


@pytest.mark.parametrize(
    ("name", "changes", "told"),
    [
        ("c-axis-ramp", ["run.polish=-1"], "run.polish = -1"),
        ("c-axis-ramp", ["run.polish=3", "search.preset=nsga-ii"], "looks for a front"),
    ],
)
def test_what_cannot_be_polished_is_refused_in_a_line(name, changes, told):
    with pytest.raises(UserError, match=told):
        load_scenario(name, changes)
