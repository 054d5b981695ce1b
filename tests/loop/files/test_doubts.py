"""What of a scenario is hardly meant: unit mistakes are told, and no scenario that is in order."""

import pytest

from hfc_design.files.doubts import doubts
from hfc_design.files.named_scenario import builtin_names, load_scenario


@pytest.mark.parametrize("name", builtin_names())
def test_no_scenario_that_comes_with_the_tool_is_doubted(name):
    assert doubts(load_scenario(name)) == []
