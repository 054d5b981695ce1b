"""The page on a design names what to connect, how it was measured, and what it does."""

import re

import made_up
import numpy as np
import pytest
from flash_folders import ALL, FEW, page, written

from hfc_design.files.design import named_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import code, machine_code
from hfc_design.formats.flash.folder import with_check


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(tmp_path_factory.mktemp)


@pytest.mark.parametrize("name", FEW)
def test_the_page_names_every_input_with_its_unit(name, folder):
    text = (folder(name) / "README.md").read_text()
    for signal, unit in code.signals(ALL[name]).items():
        assert unit
        assert re.search(rf"\| `{signal}` \| in \| {re.escape(unit)} \| \w", text), signal
    assert re.search(r"\| `command` \| out \| \w+ \| \w", text)


@pytest.mark.slow
def test_axes_that_differ_have_units_of_their_own():
    record = ALL["lin-gai-2009-fuzzy-sliding-compensated"]
    text = with_check(record, machine_code.sources(record))["README.md"]
    assert "| x, y, z | `error` | in | mm | reference less position |" in text
    assert "| a, c | `error_rate` | in | deg/s |" in text


def sensed(name, **sensors):
    """A built-in design whose scenario has these sensors."""
    design = named_design(name)
    scenario = load_scenario(design.provenance["scenario"]).model_dump(
        mode="json", exclude_none=True
    )
    scenario["sensors"] = sensors
    return design.model_copy(update={"provenance": {"scenario": scenario}})


def test_the_page_says_how_velocities_were_formed():
    text = page(
        sensed("pd-only", velocity="encoder", difference_samples=3, encoder_resolution=1e-5)
    )
    assert "velocity = (position[0] - position[3]) / 0.003;" in text
    assert "read in steps of 1e-05 rad" in text
    text = page(sensed("pd-only", velocity="observer", observer_hz=100.0))
    assert "The velocities in `error_rate` come from a tracking observer of 100.0 Hz" in text
    pole = np.exp(-2.0 * np.pi * 100.0 * 0.001)  # docs/sensors.md
    alpha, gain = map(float, re.findall(r"= (?:expected|velocity) \+ ([\d.]+) \* off;", text))
    assert alpha == pytest.approx(1.0 - pole**2, rel=1e-12)
    assert gain == pytest.approx((1.0 - pole) ** 2 / 0.001, rel=1e-12)


def test_the_page_says_which_signals_are_made_of_velocities(folder):
    text = (folder("lin-lee-1999-table-1") / "README.md").read_text()
    assert "velocities in `error_rate`, `deflection_rate`, `spindle_velocity` were the true" in text
    assert "ideal tachometer" in text


def test_the_page_says_what_is_filtered_and_limited():
    filtered = made_up.limited(made_up.linear("pid+ff", 4), 40.0)
    own = filtered.controller.model_copy(update={"derivative_hz": 90.0})
    text = page(filtered.model_copy(update={"controller": own}))
    assert "`error_rate` passes a low-pass of the first order at 90.0 Hz" in text
    assert "The command keeps to 40.0 V of either sign" in text
    assert "The command is not limited" in page(named_design("pd-only"))


def test_nothing_that_a_user_wrote_is_markup_or_code():
    evil = "<b>*/ #include [x](y) `"
    design = named_design("pd-only")
    found = with_check(
        design.model_copy(
            update={"name": evil, "score": {evil: 1.0}, "provenance": {"source": evil}}
        ),
        machine_code.sources(design.model_copy(update={"name": evil})),
    )
    assert "<b>" not in found["README.md"].replace("\\<b\\>", "")
    assert "[x](y)" not in found["README.md"]
    for text in (found["Makefile"], found["check"]["check.c"], found["check"]["vectors.csv"]):
        assert "<b>" not in text
        assert "#include [" not in text
