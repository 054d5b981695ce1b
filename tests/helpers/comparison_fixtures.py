"""Comparisons that the tests of tables, pictures and page look at."""

import pytest

HOSTILE = '</script><script>alert("1")</script> & <img src=x> {{ 7*7 }} $x^$ \x01 Ω 漢'


@pytest.fixture(scope="session")
def spindles():
    """Two motions; one design has a name that a page could fall for."""
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.simulation.comparing import compare

    designs = {"lin-lee-1999-table-1": "lin-lee-1999-table-1", HOSTILE: "pd-only"}
    names = {"c-axis-ramp": 2.0, "c-axis-step": 0.5}
    scenarios = [load_scenario(x, {"simulation.duration_s": s}) for x, s in names.items()]
    return compare(designs, scenarios, 0.2, 8)


@pytest.fixture(scope="session")
def tables():
    """An X-Y machine on a circle and on a line."""
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.simulation.comparing import compare

    names = {"feed-drive-circle": 8.0, "feed-drive-line": 4.0}
    scenarios = [load_scenario(x, {"simulation.duration_s": s}) for x, s in names.items()]
    return compare(["jee-koren-2004-flc", "jee-koren-2004-pid"], scenarios, 0.2, 6)
