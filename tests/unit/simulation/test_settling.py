"""What is called stable: known limit cycles are not, forced vibration is; the rule by hand."""

import numpy as np

from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.stability_criteria import instabilities, reasons_text

SHORT = ["simulation.duration_s=3"]


def settled(measured, failed, motions):
    """(machines, motions) for which there is no reason why it should not be stable."""
    return ~np.logical_or.reduce([*instabilities(measured, failed, motions).values()])


def test_the_rule_by_hand():
    ramp = load_scenario("c-axis-ramp", [*SHORT, "reference.velocity=0.03"])  # to 90 mrad
    good = [0.0, 0.0, 1e-3]
    rows = {
        "nominal": (good, True),
        "within 5 % of the way": ([0.0, 0.0, 4.49e-3], True),
        "beyond it": ([0.0, 0.0, 4.51e-3], False),
        "converges": ([0.3, 0.1, 1e-3], True),
        "oscillates": ([0.301, 0.0, 1e-3], False),
        "held by its limit": ([0.0, 0.101, 1e-3], False),
        "no number": ([np.nan, 0.0, 1e-3], False),
    }

    def judged(*values, where=ramp):
        measured = np.array([*values])[:, None, :]
        return settled(measured, np.zeros(measured.shape[:2], bool), [where])[:, 0].tolist()

    assert judged(*(row for row, _ in rows.values())) == [told for _, told in rows.values()]
    assert settled(np.array([[good]]), np.array([[True]]), [ramp]).tolist() == [[False]]
    # Three times the nominal one where that is more, if the nominal one settles.
    assert judged([0, 0, 20e-3], [0, 0, 59e-3], [0, 0, 61e-3]) == [True, True, False]
    assert judged([1, 0, 20e-3], [0, 0, 59e-3], [0, 0, 4e-3]) == [False, False, True]
    assert judged([0, 0, 80e-3], [0, 0, 0.0899], [0, 0, 0.091]) == [True, True, False]
    assert judged([0, 0, 0.091]) == [False]
    told = load_scenario(ramp, {"constraints.late_error": "2 mrad"})
    assert judged([0, 0, 1e-4], [0, 0, 1.9e-3], [0, 0, 2.1e-3], where=told) == [True, True, False]
    still = load_scenario(ramp, {"reference.velocity": 0.0})
    assert judged([0, 0, 5.0], [0, 0, 16.0], [0.4, 0, 0.0], where=still) == [True, True, False]


def test_reasons_are_counted_in_words():
    told = reasons_text({"is far off": 1, "oscillates": 2, "stays at a limit": 3})
    assert told == "3 stay at a limit, 2 oscillate, 1 is far off"
    assert reasons_text({}) == ""
