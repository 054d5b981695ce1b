"""The limit of a command goes with the design: into the simulator, the runtime, C and ST.

The oracle of the anti-windup is a PID written down once more with NumPy.
"""

import numpy as np
import pytest
from c_program import built, commands
from held_back import FORMS, limited, samples, stepped


@pytest.mark.parametrize("case", FORMS)
def test_the_runtime_and_c_keep_it_alike(case, tmp_path):
    name, changes = FORMS[case]
    design = limited(name, **changes)
    limit = design.limits.command
    signals = samples(design)
    expected = stepped(design, signals)
    # It does hold back, and never lets more pass; a sum alone stops within a step of it.
    assert 0.95 * limit < np.abs(expected).max() <= limit
    found = commands(built("gcc", design, tmp_path / "c"), np.stack(list(signals.values()), axis=1))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * limit)
    assert np.abs(found).max() <= limit
