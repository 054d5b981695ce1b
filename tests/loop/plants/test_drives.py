"""What holds of every drive: a population moves like its members, and a fault shows."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from driven import path
from jk04 import PARAMETER_SETS

from plants import FEED_DRIVE
from plants.milling_table import MILLING_TABLE
from plants.positioning_stage import POSITIONING_STAGE

TABLE, STAGE = MILLING_TABLE.parameters(), POSITIONING_STAGE.parameters()
LOPSIDED = STAGE._replace(viscous_asymmetry=0.3, stiction_rise=4.0)
#: Parameters, how far the parts of states go at random, the largest command, the sample time, and
#: what float64 and float32 may be off, in shares of a state and in units of each of its parts.
DRIVES = {
    "feed-drive": (
        FEED_DRIVE,
        [PARAMETER_SETS[name] for name in ("x-coulomb", "y-start", "frictionless")],
        [50.0, 2000.0],
        (128.0, 0.01),
        (1e-12, 2e-5, 1.0, 100.0),
    ),
    "milling-table": (
        MILLING_TABLE,
        [TABLE, TABLE._replace(backlash=0.0), TABLE._replace(coulomb_friction=0.0)],
        [60.0, 9.0, 0.0, 0.0],
        (10.0, 0.005),
        (1e-9, 2e-4, 0.0, np.array([0.1, 100.0, 0.1, 100.0])),
    ),
    "positioning-stage": (
        POSITIONING_STAGE,
        [
            STAGE,
            STAGE._replace(viscous_asymmetry=0.3, stiction_rise=4.0),
            STAGE._replace(offset=40.0),
        ],
        [9.0, 120.0],
        (10.0, 1e-3),
        (1e-12, 2e-5, 1.0, 10.0),
    ),
}


@pytest.mark.parametrize("name", DRIVES)
def test_a_population_moves_like_its_members(name):
    drive, sets, spans, (most, dt), (fine, coarse, share, unit) = DRIVES[name]
    random, count = np.random.default_rng(5), 24
    start = [random.uniform(-span, span, count) for span in spans]
    start[1][::4] = 0.0
    if len(spans) == 4:  # the motor within the gap and beyond
        start[2] = start[0] + random.uniform(-0.2, 0.2, count)
    commands, sets = random.uniform(-most, most, count), sets * (count // len(sets))
    rows = zip(sets, zip(*start, strict=True), commands, strict=True)
    alone = np.array([path(drive, p, x, [command], dt)[0] for p, x, command in rows])

    def one(p, x, command):
        return drive.step(drive.coefficients(p), x, command, (0.0,) * 3, dt)

    together = jax.jit(jax.vmap(one))
    for dtype, tolerance in ((jnp.float64, fine), (jnp.float32, coarse)):
        p = type(sets[0])(*(jnp.asarray(x, dtype) for x in zip(*sets, strict=True)))
        x = type(drive.initial_state(0.0))(*(jnp.asarray(x, dtype) for x in start))
        found = together(p, x, jnp.asarray(commands, dtype))
        assert {leaf.dtype for leaf in found} == {np.dtype(dtype)}
        off = np.abs(np.stack(found, axis=1) - alone)
        assert (off <= tolerance * (share * np.abs(alone) + unit)).all()


@pytest.mark.parametrize("name", DRIVES)
def test_a_command_that_is_no_number_shows_in_the_whole_state_even_at_rest(name):
    drive, (p, *_), spans, *_ = DRIVES[name]
    command = drive.accepted(drive.coefficients(p), np.nan)
    assert np.isnan(path(drive, p, [0.0] * len(spans), [command], 0.01)).all()
