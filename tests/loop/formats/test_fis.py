"""The FIS export without a program that reads it; with Octave: tests/interop/test_fis.py."""

import made_up
import pytest

from hfc_design.files.design import Design, named_design
from hfc_design.formats import FORMATS


@pytest.fixture
def written(tmp_path):
    def write(design):
        FORMATS["fis"].write(design, tmp_path / "out")
        return {file.name: file.read_text() for file in (tmp_path / "out").iterdir()}

    return write


def changed(name, change):
    data = named_design(name).model_dump(mode="json")
    change(data["controller"])
    return Design.model_validate(data)


def test_an_outermost_triangle_is_a_shoulder_up_to_the_range(written):
    text = written(named_design("jee-koren-2004-flc"))["rules.fis"]
    assert "Name='error'\nRange=[-26.0 26.0]" in text
    assert "MF1='NL':'trapmf',[-31.0 -26.0 -21.0 -16.0]" in text
    assert "MF4='ZR':'trimf',[-5.0 0.0 5.0]" in text
    assert "MF7='PL':'trapmf',[16.0 21.0 26.0 31.0]" in text


@pytest.mark.parametrize(("blu", "factor"), [({}, "0.01"), ({"blu_mm": 0.004}, "0.004")])
def test_the_compensation_counts_in_mm(written, blu, factor):
    low = made_up.LOW_VELOCITY | blu
    files = written(
        changed("jee-koren-2004-flc", lambda controller: controller.update(low_velocity=low))
    )
    assert f"compensation({factor} * signals.velocity, signals.error)" in files["controller.m"]
    assert ('"blu_mm"' in files["controller.json"]) == bool(blu)


def test_what_the_format_leaves_out_stands_in_the_head(written):
    assert (
        "the adaptation itself is not here"
        in written(named_design("jee-koren-2004-aflc"))["rules.fis"]
    )
