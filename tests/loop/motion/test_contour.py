"""Contour errors by hand and against a dense search along the path."""

import numpy as np
import pytest

from hfc_design.motion.contour import (
    local_error,
)


def test_local_error_of_traced_scalars():
    jax = pytest.importorskip("jax")
    values = (0.3, -0.2, 0.6, 0.8, 0.05)
    traced = jax.jit(jax.vmap(local_error))(*np.array(values)[:, None])
    assert float(traced[0]) == pytest.approx(local_error(*values), rel=1e-6)
