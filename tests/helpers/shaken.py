"""Numbers as another processor may round them, and a little worse."""

import numpy as np


def shaken(*numbers, times=6, size=1e-12):
    """The numbers as they are, and so often each off by up to a share of itself."""
    rng = np.random.default_rng(1)
    yield numbers
    for _ in range(times):
        yield tuple(float(x * (1.0 + size * rng.uniform(-1.0, 1.0))) for x in numbers)
