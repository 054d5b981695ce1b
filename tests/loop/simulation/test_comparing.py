"""Designs side by side: machines and numbers against single runs, counts and ratios by hand."""

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.comparing import compare

SHORT = {"simulation.duration_s": 0.3}


@pytest.fixture(scope="module")
def found():
    scenarios = [load_scenario(name, SHORT) for name in ("c-axis-ramp", "c-axis-ramp-cutting")]
    told = []
    designs = ["lin-lee-1999-table-1", "pd-only"]
    result = compare(designs, scenarios, 0.2, 7, 3, lambda *news: told.append(news))
    return result, scenarios, told


def test_progress_ends_where_all_is_done(found):
    *_, told = found
    whats, done, totals = zip(*told, strict=True)
    assert set(totals) == {2 * 2 * 8}
    assert list(done) == sorted(done)
    assert done[-1] >= totals[0] - 1
    assert whats[-1] == "pd-only in c-axis-ramp-cutting"
