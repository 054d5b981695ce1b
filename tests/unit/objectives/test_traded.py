"""What the names of objectives mean in a scenario."""

import numpy as np
import pytest
from wording import refused

from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.verdict import Ensemble

SEARCH = "search={{preset='nsga-ii', objectives={}}}"


def told(scenario, *names, changes=()):
    found = load_scenario(scenario, [SEARCH.format([*names]), *changes])
    return [(one.name, one.unit, one.measure and one.measure.name) for one in found.traded]


def test_units_are_no_measure():
    assert told("c-axis-ramp", "tracking", "units")[1] == ("units", "1", None)


@pytest.mark.parametrize(
    "names",
    [
        ["tracking"],
        ["tracking", "effort", "chatter", "iae"],
        ["tracking", "speed"],
        ["iae", "iae"],
        ["tracking", "rms_error"],
        ["tracking", "rms_contour_error"],
        ["tracking", "band_time"],
    ],
)
def test_what_cannot_be_traded_is_told_in_a_line(names):
    with refused() as found:
        told("c-axis-ramp", *names)
    assert "search.objectives" in found.refusal
    assert "\n" not in found.refusal


def test_only_hierarchies_have_units():
    with refused() as found:
        told("c-axis-ramp", "tracking", "units", changes=["controller={kind='pd'}"])
    assert "search.objectives" in found.refusal


def test_costs_are_means_of_motions_and_of_machines_what_is_kept():
    values = np.array([[[[1.0], [4.0]], [[3.0], [8.0]]]])  # motions (1, 4) and (3, 8)
    mean = [(1 + 2 * 4) / 3, (3 + 2 * 8) / 3]
    assert Ensemble((1.0, 2.0)).costs(values) == pytest.approx(np.array([[sum(mean) / 2]]))
    assert Ensemble((1.0, 2.0), keep="worst").costs(values) == pytest.approx(max(mean))
    assert Ensemble((1.0, 2.0), keep="quantile").costs(values) == pytest.approx(max(mean))
