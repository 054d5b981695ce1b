"""The scalar building blocks of a control step and their derivatives."""

import jax
import pytest

from plants.blocks import once, ratio


def test_once_is_the_number_and_its_slope():
    value, slope = jax.jvp(once, (3.0,), (0.5,))
    assert (value, slope) == (3.0, 0.5)


def test_ratio_follows_the_quotient_rule():
    value, slope = jax.jvp(ratio, (3.0, 4.0), (0.5, -0.25))
    assert value == 0.75
    assert slope == pytest.approx((0.5 * 4.0 - 3.0 * -0.25) / 4.0**2)
