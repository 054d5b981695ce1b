"""The feed drive under controllers of Jee & Koren (2004), against their figures."""

import math

import jax
import jax.numpy as jnp
import numpy as np
from feed_oracle import output
from jk04 import CHANGE_TERMS, ERROR_TERMS, PARAMETER_SETS, rule_singletons

from plants import FEED_DRIVE
from plants.feed_drive import (
    FeedDriveParameters,
    FeedDriveState,
    accepted,
    coefficients,
    step,
)

FREE = (0.0, 0.0, 0.0)

# The paper's machine: two axes, T = 10 ms, whole BLUs from interpolator and encoder, whole units
# to the amplifier. Both controllers are plain transcriptions, so that the figures test the plant.
SUBSTEPS = 4


@jax.jit
def sample(c, x, command):
    """What both encoders read after the next 10 ms under ``command``, and the state."""

    def one(c, x, command):
        held = accepted(c, command)
        moved = jax.lax.fori_loop(
            0, SUBSTEPS, lambda _, x: step(c, x, held, FREE, 0.01 / SUBSTEPS), x
        )
        return moved, FEED_DRIVE.measured(c, moved).position

    return jax.vmap(one)(c, x, command)


def circle(controller, sets, radius, cycles):
    """Axial X and contour error [BLU], (cycles, 2000) each, of a circle in 20 s."""
    p = FeedDriveParameters(*np.transpose([PARAMETER_SETS[name] for name in sets]))
    c = coefficients(p)
    x = FeedDriveState(jnp.array([radius, 0.0]), jnp.zeros(2))
    seen, laws, axial, contour = np.array([radius, 0.0]), [controller(), controller()], [], []
    for k in range(2000 * cycles):
        angle = 2 * math.pi * k / 2000
        reference = radius * np.array([math.cos(angle), math.sin(angle)])
        position = np.asarray(x.position)
        axial.append(reference[0] - position[0])
        contour.append(math.hypot(*position) - radius)
        errors = np.round(reference) - seen
        command = np.array([law(error) for law, error in zip(laws, errors, strict=True)])
        x, read = sample(c, x, command)
        seen = np.asarray(read)
    return np.reshape(axial, (cycles, 2000)), np.reshape(contour, (cycles, 2000))


def pid():
    """PID of JK04 5.1.2 on the time scale: the integral of e dt and the derivative de / T."""
    integral, previous = 0.0, 0.0

    def law(e):
        nonlocal integral, previous
        integral += e * 0.01
        change, previous = e - previous, e
        return 1.5 * e + 8.1 * integral + 0.1 * change / 0.01

    return law


def flc(factor=1.0):
    """FLC of JK04 Tables 1 and 3 without an integral; 0 where no rule fires."""
    previous, table = 0.0, factor * np.array(rule_singletons("I"))

    def law(e):
        nonlocal previous
        change, previous = e - previous, e
        return output(ERROR_TERMS, CHANGE_TERMS, table, e, change)

    return law


def rms(values):
    return np.sqrt(np.mean(values**2, axis=-1))


def test_pid_with_coulomb_friction_has_the_published_contour_errors():
    """Fig. 12(b): RMS 3.4 and maximum 15.6 BLU; independently found for F_c = 15: 3.52, 15.9."""
    _, contour = circle(pid, ["x-coulomb", "y-coulomb"], 2000.0, 2)
    np.testing.assert_allclose(rms(contour), 3.4, rtol=0.1)
    np.testing.assert_allclose(abs(contour).max(axis=1), 15.6, rtol=0.1)
    np.testing.assert_allclose(rms(contour)[1:], 3.52, rtol=0.015)  # after the start
    np.testing.assert_allclose(abs(contour).max(axis=1), 15.9, rtol=0.02)


def test_pid_without_friction():
    """Independently found: 0.88 BLU; the paper prints 1.5, which needs a dead zone."""
    _, contour = circle(pid, ["frictionless", "frictionless"], 2000.0, 2)
    np.testing.assert_allclose(rms(contour), 0.88, atol=0.02)


def test_flc_with_start_friction_has_the_published_axial_error():
    """Fig. 10(a): approximately 16.2 BLU in every cycle."""
    axial, _ = circle(flc, ["x-start", "y-start"], 4000.0, 2)
    np.testing.assert_allclose(rms(axial), 16.2, atol=0.3)


def test_flc_with_doubled_singletons_needs_no_other_plant():
    """Fig. 10(a) on the plant of Fig. 12: independently found 17.1 BLU, printed 16.2."""
    axial, contour = circle(lambda: flc(2.0), ["x-coulomb", "y-coulomb"], 4000.0, 2)
    np.testing.assert_allclose(rms(axial), 16.2, rtol=0.07)
    np.testing.assert_allclose(rms(axial)[1], 17.1, atol=0.05)
    assert rms(contour)[-1] > 5.0


def test_pid_with_a_dead_zone_without_friction():
    """Fig. 12(b): 1.5 BLU; independently found for errors up to 1 BLU that count as 0: 1.65."""

    def dead_zoned():
        law = pid()
        return lambda e: law(e if abs(e) > 1.0 else 0.0)

    _, contour = circle(dead_zoned, ["frictionless", "frictionless"], 2000.0, 2)
    np.testing.assert_allclose(rms(contour)[1], 1.65, atol=0.02)
