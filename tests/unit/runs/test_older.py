"""Run folders that an earlier version left broken off: what had failed scored 0 in them."""

import numpy as np
import pytest
from places import DATA

from hfc_design.runs import run, stored

#: A race of five PD controllers after its first generation, in which four diverged.
BROKEN_OFF = DATA / "broken_off_1"


def test_what_had_failed_ranks_last(tmp_path):
    scenario = run.opened_run(BROKEN_OFF)
    state = stored.load(BROKEN_OFF / run.CHECKPOINT, scenario, {}).state
    assert np.isneginf(state.score).tolist() == [False, True, True, True, True]
    assert state.score[0] == pytest.approx(74.610207, rel=1e-6)
