"""Numbers as they are read, not as they are stored."""

import pytest

from hfc_design.core.wording import percent


@pytest.mark.parametrize(
    ("share", "told"),
    [
        (0.0, "0 %"),
        (5e-34, "less than 0.001 %"),
        (1.234e-4, "0.012 %"),
        (0.9951, "100 %"),
        (3.4, "340 %"),
    ],
)
def test_no_share_has_an_exponent(share, told):
    assert percent(share) == told
