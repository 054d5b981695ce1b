"""The page of a comparison: nothing from outside, names are only text, curves can be zoomed."""

import pytest

from hfc_design.report.comparison.page import page


@pytest.fixture(scope="module")
def written(spindles):
    return page(spindles, "hfc compare <a> b").html.decode()


def test_the_same_comparison_gives_the_same_bytes(spindles, written):
    assert page(spindles, "hfc compare <a> b").html.decode() == written


def test_it_is_small_and_says_what_is_compared(written, tables):
    assert len(written) < 450_000
    assert "8 others" in written.replace("\n", " ")
    assert "<code>hfc compare &lt;a&gt; b</code>" in written
    other = page(tables).html.decode()
    assert other.count("times enlarged") == 2
    assert "Again:" not in other
