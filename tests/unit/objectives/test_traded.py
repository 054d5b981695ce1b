"""What the names of objectives mean in a scenario."""

import pytest

from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario

SEARCH = "search={{preset='nsga-ii', objectives={}}}"


def told(scenario, *names, changes=()):
    found = load_scenario(scenario, [SEARCH.format([*names]), *changes])
    return [(one.name, one.unit, one.measure and one.measure.name) for one in found.traded]


def test_units_are_no_measure():
    assert told("c-axis-ramp", "tracking", "units")[1] == ("units", "1", None)


@pytest.mark.parametrize(
    ("names", "why"),
    [
        (["tracking"], "has to be two or three objectives, not 1"),
        (["tracking", "effort", "chatter", "iae"], "has to be two or three objectives, not 4"),
        (["tracking", "speed"], "speed: is no objective; there is tracking, effort, units"),
        (["iae", "iae"], "iae: stands there twice"),
        (["tracking", "rms_error"], "tracking and rms_error: are the same here"),
        (["tracking", "rms_contour_error"], "is of a machine that follows a path"),
        (["tracking", "band_time"], "band_time: needs fitness.band"),
    ],
)
def test_what_cannot_be_traded_is_told_in_a_line(names, why):
    with pytest.raises(UserError) as refused:
        told("c-axis-ramp", *names)
    assert why in str(refused.value)
    assert "search.objectives" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_only_hierarchies_have_units():
    with pytest.raises(UserError, match="'pd' has no hierarchy whose units could be counted"):
        told("c-axis-ramp", "tracking", "units", changes=["controller={kind='pd'}"])


def test_costs_are_means_of_motions_and_of_machines_what_is_kept():
    import numpy as np

    from hfc_design.objectives.verdict import Ensemble

    values = np.array([[[[1.0], [4.0]], [[3.0], [8.0]]]])  # motions (1, 4) and (3, 8)
    mean = [(1 + 2 * 4) / 3, (3 + 2 * 8) / 3]
    assert Ensemble((1.0, 2.0)).costs(values) == pytest.approx(np.array([[sum(mean) / 2]]))
    assert Ensemble((1.0, 2.0), keep="worst").costs(values) == pytest.approx(max(mean))
    assert Ensemble((1.0, 2.0), keep="quantile").costs(values) == pytest.approx(max(mean))
