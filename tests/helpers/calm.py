"""Objectives of one's own, and a short search of a PD."""

import jax.numpy as jnp

from hfc_design import api

TITLE = "fitness, LL eq. 5 / (1 + 300 stick share)"
#: In 0.3 s, with a PD part alone; a large derivative gain diverges.
SMALL = {
    "simulation.duration_s": 0.3,
    "search.population": 16,
    "search.generations": 6,
    "controller": {"kind": "pd", "ranges": {"kd": [30.0, 1e8]}},
}
#: Below zero: minus the largest error in mrad; and one that is never a number.
CALM = api.Objective(
    lambda zero: zero,
    lambda sums, moments, path: jnp.maximum(sums, jnp.abs(moments[0].error)),
    lambda sums: -1000.0 * sums,
    name="calm",
    title="largest error",
    unit="mrad",
)
LOST = CALM._replace(name="lost", score=lambda sums: jnp.nan * sums)


def given(name):
    """An objective that is the number that it is given."""
    return api.Objective(lambda zero: zero, lambda s, moments, path: s, lambda s: s, name=name)
