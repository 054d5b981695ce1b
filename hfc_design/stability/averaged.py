"""A drive in the mean over its way: what is left of one whose force depends on the position.

Cogging of a linear motor, say, keeps a drive from ever moving steadily, and is no part of a linear
model: it comes and goes while the drive slides. So steps from many places along the way are taken
together, with the weights of a window (the square of Hann's) whose sum over any wave that is long
beside the places' distance and short beside the way is 0.
"""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from hfc_design.core.numbers import Floats, Parameters
from hfc_design.stability.sliding import Slides, Step, differentiated
from plants import Drive

#: Places along the way.
PLACES = 1024
#: Ways that are tried [of the position]: one of them holds many waves, and of each many places. No
#: round number, which a wave could share with the places.
WAYS = 1.618 * 10.0 ** np.arange(-6.0, 6.5, 0.5)
#: A force has the mean 0 along a way where so much of its slope is left.
LEFT = 1e-3
#: Ways that leave less are alike: what is left there is rounding, of which a longer way has more.
NOTHING = 1e-9


class Averaged(Slides):
    """A drive in the mean over a way; call it where JAX has float64.

    ``along`` (states,) is what a unit of way moves. Without it that is found in the mean over a way
    that moves all encoders alike, where what is linear stays as it is.
    """

    def __init__(
        self, drive: Drive, parameters: Parameters, way: float, along: Floats | None = None
    ):
        super().__init__(drive, parameters)
        fields = type(drive.initial_state(0.0))._fields
        places = {*drive.encoders, drive.position, drive.seen[0]}
        moved = np.array([float(name in places) for name in fields]) if along is None else along
        shares = (np.arange(PLACES) + 0.5) / PLACES - 0.5
        self._shifts = way * np.outer(shares, moved)
        self.reach = np.abs(self._shifts).max(0)
        self._mean = partial(_mean, drive, parameters)
        self.along = along

    def step(self, state: Floats, command: float, dt: float) -> Step:
        """In the mean from all places, so that it does not matter from which one."""
        one = self._taken(state, command, dt)[0]
        along = self.rigid(one) if self.along is None else self.along
        return one._replace(a=one.a - np.outer(one.a @ along - along, self.seen))

    def rigid(self, one: Step) -> Floats:
        """(states,) what a unit of way moves if the step changes by it as little as can be."""
        moved, others = one.a - np.eye(len(one.a)), self.seen == 0.0
        along = self.seen.copy()
        along[others] = -np.linalg.lstsq(moved[:, others], moved @ self.seen)[0]
        return along

    def found(self, dt: float) -> tuple[float, Floats]:
        """Of what a unit of way changes in a step, what is left in the mean; and ``along``.

        nan: it changes nothing in any step, or there is no step from some place.
        """
        one, slopes = self._taken(np.zeros(len(self.seen)), 0.0, dt)
        if not np.isfinite(slopes).all():
            return np.nan, self.seen
        along = self.rigid(one) if self.along is None else self.along
        each = np.linalg.norm(slopes @ along - along, axis=1)
        with np.errstate(invalid="ignore"):
            left = np.linalg.norm(one.a @ along - along) / np.sqrt(np.mean(each**2))
        return float(left), along

    def _taken(self, state: Floats, command: float, dt: float) -> tuple[Step, Floats]:
        """The mean of steps, and the slopes of each (places, states, states)."""
        mean, slopes = self._mean(state, command, dt, self._shifts)
        return Step(*map(np.asarray, mean)), np.asarray(slopes)


def averaged(drive: Drive, parameters: Parameters, dt: float) -> Averaged | None:
    """The drive in the mean over that way over which what depends on the position has the mean 0.

    None where nothing does, or it has no mean of 0 along any way, as a spring.
    """
    best, least = None, LEFT
    for way in WAYS:
        along = Averaged(drive, parameters, way).found(dt)[1]
        one = Averaged(drive, parameters, way, along)
        if (left := max(one.found(dt)[0], NOTHING)) < least:
            best, least = one, left
    return best


@partial(jax.jit, static_argnums=0)
def _mean(drive: Drive, parameters: Parameters, x: Any, command: Any, dt: Any, shifts: Any) -> Any:
    """The state after a step, its derivatives by state, command and load in the mean.

    And those by the state from each of the places, (places, states, states).
    """
    turns = jnp.pi * (jnp.arange(len(shifts)) + 0.5) / len(shifts)
    weights = jnp.sin(turns) ** 4 / jnp.sum(jnp.sin(turns) ** 4)
    one = jax.vmap(lambda shift: differentiated(drive, parameters, x + shift, command, dt))
    after, slopes = one(shifts)
    parts = (after - shifts, *slopes)
    return [jnp.tensordot(weights, part, axes=1) for part in parts], slopes[0]
