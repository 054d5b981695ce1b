"""Quantities with units, against what people know of them."""

import math

import pytest
from pydantic import TypeAdapter, ValidationError

from hfc_design.core.quantities import number
from hfc_design.core.records import Quantity

READ = TypeAdapter(Quantity).validate_python


@pytest.mark.parametrize(
    ("written", "unit", "found"),
    [
        ("20 urad", "rad", 20e-6),
        ("20 µrad", "rad", 20e-6),
        ("90 deg", "rad", math.pi / 2),
        ("1e-3 mrad/s", "rad/s", 1e-6),
        ("0.1V", "V", 0.1),
        ("3 N m", "N m", 3.0),
        ("50 ms", "s", 0.05),
        ("2 unit", "unit", 2.0),
        (3, "V", 3.0),
        ("10 BLU", "BLU", 10.0),
    ],
)
def test_quantities(written, unit, found):
    assert number(READ(written), unit) == pytest.approx(found, rel=1e-12)


def test_a_blu_has_millimetres():
    assert number("5 um", "BLU", 0.01) == pytest.approx(0.5)
    assert number("6 mm/min", "BLU/s", 0.01) == pytest.approx(10.0)


@pytest.mark.parametrize("written", ["20 V", "20 furlong", "2 unit"])
def test_of_something_else(written):
    with pytest.raises(ValueError, match="must be a quantity in rad"):
        number(READ(written), "rad")


@pytest.mark.parametrize(
    "written",
    [
        "20",
        "urad",
        "9**9**9 rad",
        "1 rad^99",
        "-inf rad",
        "1e999 rad",
        "3 nothing",
        "",
        "1 " * 99,
        "1_0 rad",
        "１ rad",
    ],
)
def test_what_is_none(written):
    with pytest.raises(ValidationError, match=r"must be a number with a unit|unknown unit"):
        READ(written)
