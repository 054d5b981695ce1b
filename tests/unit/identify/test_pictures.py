"""What the pictures of an identification show, read back from the figures."""

from types import SimpleNamespace

import numpy as np
import pytest
from carts import CART, EVERY, forced, recorded
from read_figures import lines_of

from hfc_design.identify import page
from hfc_design.identify.outcome import Check

STEPS, BEGUN, WORST = 1000, 100, 700
TIME = EVERY * np.arange(STEPS)
REPLAY = 0.1 * np.sin(3.0 * TIME) + 2.0  # [m]


@pytest.fixture
def found():
    """A log that is 1 µm off its replay, and 40 µm less in one sample; it counts after a while."""
    off = np.full(STEPS, 1e-6)
    off[WORST] = -40e-6
    told = recorded(REPLAY + off, forced(STEPS))
    off[:BEGUN] = 0.0
    checks = [Check(name, "open loop", 1.0, 1.0, off) for name in ("one.csv", "two.csv")]
    free = SimpleNamespace(drive=CART)
    return SimpleNamespace(recording=told, checks=tuple(checks), free=free, position_unit="m")


def test_the_replay_lies_beside_the_log(found):
    first, command, off = page.replayed(found).axes
    lines = lines_of(first)
    np.testing.assert_array_equal(lines["recorded"][1], found.recording.place)
    assert np.isnan(lines["replayed"][1][:BEGUN]).all()
    np.testing.assert_allclose(lines["replayed"][1][BEGUN:], REPLAY[BEGUN:], rtol=0, atol=1e-12)
    labels = [axes.get_ylabel() for axes in (first, command, off)]
    assert labels == ["position [m]", "command [N]", "off by [µm]"]
    assert np.nanmin(off.lines[0].get_ydata()) == pytest.approx(-40.0)


def test_where_it_is_off_most_is_seen_from_near(found):
    upper, lower = page.closely(found).axes
    lines = lines_of(upper)
    time, recorded_there = lines["recorded"]
    assert time[[0, -1]] == pytest.approx([0.675, 0.725])
    apart = recorded_there - lines["replayed"][1]
    assert apart[25] == pytest.approx(-40.0, abs=1e-4)
    assert np.delete(apart, 25) == pytest.approx(1.0, abs=1e-4)
    assert upper.get_ylabel() == "position less cubic [µm]"
    assert np.ptp(recorded_there) < 60.0  # of 10 mm that it goes there
    (dot,) = (line for line in lower.lines if line.get_marker() == "o")
    assert np.ravel(dot.get_data()) == pytest.approx([0.7, -40.0])
