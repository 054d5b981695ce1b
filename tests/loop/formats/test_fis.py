"""The FIS export of a feed drive without a program that reads it."""

import made_up
import pytest
from exported import texts

from hfc_design.files.pairing import load_design


def test_an_outermost_triangle_is_a_shoulder_up_to_the_range():
    text = texts(load_design("jee-koren-2004-aflc"), "fis")["rules.fis"]
    assert "Name='error'\nRange=[-26.0 26.0]" in text
    assert "MF1='NL':'trapmf',[-31.0 -26.0 -21.0 -16.0]" in text
    assert "MF4='ZR':'trimf',[-5.0 0.0 5.0]" in text
    assert "MF7='PL':'trapmf',[16.0 21.0 26.0 31.0]" in text
    assert "the adaptation itself is not here" in text


@pytest.mark.parametrize(("blu", "factor"), [({}, "0.01"), ({"blu_mm": 0.004}, "0.004")])
def test_the_compensation_counts_in_mm(blu, factor):
    changes = {"controller.low_velocity": made_up.LOW_VELOCITY | blu}
    files = texts(load_design("jee-koren-2004-flc", changes), "fis")
    assert f"compensation({factor} * signals.velocity, signals.error)" in files["controller.m"]
    assert ('"blu_mm"' in files["controller.json"]) == bool(blu)
