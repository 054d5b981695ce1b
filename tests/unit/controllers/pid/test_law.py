"""The PID controller: by hand."""

import pytest

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.pid import PidGains, initial_memory, sample
from hfc_design.core.numbers import SCALARS


def test_law_by_hand():
    law = AxisLaw(sample, initial_memory, 0.01)
    memory = law.initial_memory(0.0)
    gains = PidGains(1.5, 8.1, 0.1)
    first, memory = law.step(SCALARS, gains, memory, {"error": 2.0})
    assert first == pytest.approx(1.5 * 2 + 8.1 * 0.01 * 2 + 0.1 * 2 / 0.01)
    second, _ = law.step(SCALARS, gains, memory, {"error": 1.0})
    assert second == pytest.approx(1.5 * 1 + 8.1 * 0.01 * 3 - 0.1 * 1 / 0.01)
