"""Comparisons that the tests of tables, pictures and page look at: one program for each."""

import pytest

HOSTILE = '</script><script>alert("1")</script> & <img src=x> {{ 7*7 }} $x^$ \x01 Ω 漢'
SOFTER = "jee-koren-2004-soft"


def compared(designs, motions, machines):
    """Comparison of designs in motions, by name: of so many seconds."""
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.simulation.comparison import compare

    scenarios = [load_scenario(x, {"simulation.duration_s": s}) for x, s in motions.items()]
    return compare(designs, scenarios, 0.2, machines)


@pytest.fixture(scope="session")
def spindles():
    """Two motions; one design has a name that a page could fall for."""
    from hfc_design.files.loop_setup import load_design

    softer = load_design("pd-only", ["controller.pd.kp=1000"])
    motions = {"c-axis-ramp": 0.5, "c-axis-step": 0.5}
    return compared({"pd-only": "pd-only", HOSTILE: softer}, motions, 8)


@pytest.fixture(scope="session")
def tables():
    """An X-Y machine on a circle and on a line."""
    from hfc_design.files.loop_setup import load_design

    softer = load_design("jee-koren-2004-pid", ["controller.pid.k_p=1", "controller.pid.k_i=20"])
    motions = {"feed-drive-circle": 8.0, "feed-drive-line": 8.0}
    return compared({"jee-koren-2004-pid": "jee-koren-2004-pid", SOFTER: softer}, motions, 6)
