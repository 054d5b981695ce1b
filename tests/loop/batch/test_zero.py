"""Scores and metrics of 0, and those that no file can hold: the report is written all the same."""

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.report import parts
from hfc_design.simulation.evaluating import evaluate


def test_a_contour_error_of_zero_or_no_number_is_told():
    scenario = load_scenario("feed-drive-circle", {"simulation.duration_s": 5.0})
    name = "jee-koren-2004-flc"
    found = evaluate(load_design(name), scenario)
    key = next(iter(found.metrics))
    for value, told in ((0.0, "a contour error of 0 BLU"), (None, "a contour error of inf BLU")):
        own = found._replace(metrics=found.metrics | {key: value})
        text = parts.summary(scenario, own, {name: found})
        assert told in text
        assert "times as large" not in text
