"""Pages of a run and of a lone design in a browser."""

import phone
import pytest


def test_it_fits_a_phone(report, lone, tmp_path):
    assert phone.figures_that_fit(report[1], tmp_path) == 13
    assert phone.figures_that_fit(lone, tmp_path) == 12


@pytest.mark.parametrize("width", [400, 800, 1100, 1300])
def test_what_others_do_is_seen_without_scrolling(report, tmp_path, width):
    (window, (table, scrolled), *others) = phone.widths(report[1], tmp_path, width)
    assert window == width
    assert table >= scrolled or width == 400
    for left, right in others:
        assert 0 <= left < right <= width
