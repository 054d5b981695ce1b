"""Feed-drive design files: the loop and the runtime agree."""

import feed_oracle
import jax
import numpy as np
import pytest
from feed_designs import DESIGNS, five, jax_motion, runtime_motion
from lifted import controller_of


@pytest.fixture(scope="module")
def rough():
    """A rough reference, and five individuals of which the first is the design."""
    design = DESIGNS["jee-koren-2004-aflc"]
    controller, one = controller_of(design)
    random = np.random.default_rng(3)

    def varied(leaf):
        factors = random.uniform(0.95, 1.05, (1,) * (leaf.ndim - 1) + (5,))
        factors[..., 0] = 1.0
        return leaf * factors

    reference = feed_oracle.errors(600, 3)
    many = jax.tree.map(varied, one)
    return design, controller, many, reference, jax_motion(controller, many, reference)


def test_the_loop_equals_the_runtime_on_a_rough_reference(rough):
    design, _, _, reference, found = rough
    expected = list(runtime_motion(design, reference))
    np.testing.assert_allclose(found[:, 0], expected, rtol=1e-12, atol=1e-12)


def test_a_population_equals_its_individuals(rough):
    _, controller, many, reference, together = rough
    assert np.ptp(together[-1]) > 0.1
    for k in range(5):
        own = jax.tree.map(lambda leaf, k=k: leaf[..., k : k + 1], many)
        alone = jax_motion(controller, five(own), reference)
        np.testing.assert_allclose(together[:, k], alone[:, 0], rtol=1e-12, atol=1e-12)
