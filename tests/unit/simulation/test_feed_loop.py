"""X-Y machines: bad input, and a path that is cut short."""

import pytest
from wording import refused

from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.score_tables import notes

CIRCLE = "feed-drive-circle"


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ("reference.feed_mm_min=99999.0", "reference"),
        ("reference={kind='ramp'}", "reference.kind"),
        ("plant.axes={}", "reference.kind"),
        ("plant.axes.x.gain=-1.0", "plant.axes.x"),
        ("fitness.kind='best'", "fitness"),
    ],
)
def test_machines_that_cannot_follow_are_refused(change, where):
    with refused() as found:
        load_scenario(CIRCLE, [change])
    assert found.refusal.startswith(f"{CIRCLE}: {where}")


def test_a_path_that_the_simulation_cuts_short_is_told():
    """60 s of a circle: said of 10 s, not of all of it."""
    whole, part = (load_scenario(CIRCLE, {"simulation.duration_s": x}) for x in (60.0, 10.0))
    assert notes(whole, {}) == []
    assert "ends after 10 s of a path of 60 s" in notes(part, {})[0]
