"""Candidates of an experiment: from rest to rest, inside the limits, with a limited jerk."""

import numpy as np
import pytest

from hfc_design.identify.segments import Limits, segments

EVERY, STEPS = 1e-3, 2500
UNITS = {"error": "m", "command": "V"}
LIMITS = Limits(travel=0.2, speed=0.25, acceleration=2.5, command=10.0)


@pytest.mark.parametrize("add", [False, True])
def test_every_candidate_keeps_the_limits_by_its_differences(add):
    found = [*segments(LIMITS, EVERY, STEPS, add)]
    assert len({one.told(UNITS) for one in found}) == len(found)
    assert any(one.added.any() for one in found) == add
    for one in found:
        assert len(one.reference) == len(one.added) == STEPS
        assert abs(one.reference[0]) < 1e-5
        assert abs(one.reference[-1]) < 1e-5
        assert np.abs(one.reference).max() <= 0.5 * LIMITS.travel * (1.0 + 1e-9)
        assert np.abs(np.diff(one.reference)).max() / EVERY <= LIMITS.speed * (1.0 + 1e-9)
        fastest = np.abs(np.diff(one.reference, 2)).max() / EVERY**2
        assert fastest <= LIMITS.acceleration * (1.0 + 1e-6)
        assert np.abs(one.added).max() <= LIMITS.command


def test_moves_have_the_jerk_of_half_the_time_to_full_speed():
    """Acceleration a within half of v / a: jerk 2 a^2 / v by hand."""
    first = next(iter(segments(LIMITS, EVERY, STEPS, False)))
    jerk = np.abs(np.diff(first.reference, 3)).max() / EVERY**3
    by_hand = 2.0 * LIMITS.acceleration**2 / LIMITS.speed
    # A reversal at once changes the acceleration twice as much where moves join.
    assert 0.9 * by_hand < jerk < 2.2 * by_hand
    assert first.moves[0] == (0.5 * LIMITS.travel, LIMITS.speed)
    assert first.moves[-1][0] == 0.0


def test_a_segment_tells_its_sizes_with_units():
    """Moves over the whole travel; 3, 10 and 30 % of the largest command."""
    moves, *others = (one.told(UNITS) for one in segments(LIMITS, EVERY, STEPS, True))
    assert moves.endswith("moves of 0.2 m at 0.25 m/s")
    assert {words.split("up to ")[1] for words in others if "bit" in words} == {
        "0.3 V",
        "1 V",
        "3 V",
    }
