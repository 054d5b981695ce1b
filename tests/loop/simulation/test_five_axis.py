"""Scenarios of five axes."""

import hfc_design.api as hfc


def test_a_scenario_spells_out_what_counts_only():
    text = hfc.load_scenario("five-axis-program").model_dump(mode="json")["reference"]
    assert "acceleration_mm_s2" not in text
    assert "limits" not in hfc.load_scenario("feed-drive-contour").model_dump()["reference"]
    assert hfc.load_scenario(hfc.load_scenario("five-axis-blade").model_dump(mode="json"))
