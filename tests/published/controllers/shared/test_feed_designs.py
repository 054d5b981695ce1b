"""Every feed-drive design: the loop and the runtime agree on a circle, in either precision."""

import feed_oracle
import numpy as np
import pytest
from feed_designs import DESIGNS, LARGE, NAMES, circle, five, jax_motion, runtime_motion
from lifted import controller_of


@pytest.mark.parametrize("name", DESIGNS)
def test_the_loop_equals_the_runtime(name):
    design, controller, gains = DESIGNS[name], *controller_of(DESIGNS[name])
    rough = [feed_oracle.errors(600, 3)] if name in NAMES[2:] else []  # of those that learn
    for reference in (circle(), *rough):
        expected = np.array(list(runtime_motion(design, reference)))
        found = jax_motion(controller, five(gains) if name in LARGE else gains, reference)
        assert np.abs(expected).max() > 10.0
        np.testing.assert_allclose(found[:, 0], expected, rtol=1e-12, atol=1e-12)
