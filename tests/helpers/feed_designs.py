"""Feed-drive designs in the runtime and, as in the simulator, as a population."""

import json
from functools import partial

import jax
import jax.numpy as jnp
import made_up
import numpy as np
from jax import lax

from hfc_design.controllers.controller import View, begun
from hfc_design.core import devices
from hfc_design.core.lanes import LANES
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.runtime import Controller
from hfc_design.simulation.stepping import nested

devices.configure()

NAMES = [
    "jee-koren-2004-pid",
    "jee-koren-2004-flc",
    "jee-koren-2004-aflc",
    "jee-koren-1995-soflc",
]
X_AXIS = {
    "forward": [0.05, -1.16, 6.54],
    "backward": [-0.04, -1.0, -6.43],
    "highest_velocity_mm_s": 12.0,
    "breakaway": [6.54, -6.43],
    "smallest_error": 2.0,
}


def changed(name, **controller):
    """A built-in design with keys of its controller replaced."""
    data = json.loads(design_json(load_design(name)))
    data["controller"] |= controller
    return parse_design(json.dumps(data), "mine.json")


DESIGNS = {name: load_design(name) for name in NAMES}
for kind in ("2004-flc", "2004-aflc", "1995-soflc"):
    DESIGNS[f"{kind} with all terms"] = changed(
        f"jee-koren-{kind}", integral_gain=8.0, low_velocity=X_AXIS
    )
DESIGNS["2004-aflc with options"] = made_up.with_options("aflc", 5)
DESIGNS["pid with a dead zone"] = changed("jee-koren-2004-pid", dead_zone=1.0)
for form in ("P", "PI"):
    DESIGNS[f"flc {form}"] = changed("jee-koren-2004-flc", form=form)
#: Of these also populations are compiled.
LARGE = ("2004-aflc with all terms", "1995-soflc with all terms")


def circle(count=600):
    """Reference of a circle's axis in whole BLU."""
    return np.rint(1000.0 * (1 - np.cos(2 * np.pi * np.arange(count) / 400))).tolist()


def drive(position, velocity, command):
    """A drive of gain 28.3 and 55 ms under a held command, in 10 ms."""
    velocity = velocity + 0.01 / 0.055 * (28.3 * command - velocity)
    return position + 0.01 * velocity, velocity


def signals_of(position, velocity, reference, floor):
    return {"error": reference - floor(position + 0.5), "velocity": velocity, "position": position}


def runtime_motion(design, references):
    controller = Controller(design)
    position = velocity = 0.0
    for reference in references:
        command = controller.step(signals_of(position, velocity, reference, np.floor))
        yield command
        position, velocity = drive(position, velocity, float(np.clip(command, -128, 127)))


def jax_motion(controller, gains, references, dtype=np.float64):
    """Commands (steps, individuals) of a population under vmap, sliced as in the simulator."""
    gains = jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype), gains)
    found = _jax_motion(controller, gains, jnp.asarray(references, dtype))
    assert found.dtype == dtype
    return np.asarray(found)


@partial(jax.jit, static_argnums=0)
def _jax_motion(controller, gains, references):
    zeros = jnp.zeros(jax.tree.leaves(gains)[0].shape[-1], references.dtype)
    memory = begun(controller, LANES, zeros, jax.tree.map(nested, gains))
    start = memory, zeros, zeros

    def sample(gains, carry, reference):
        memory, position, velocity = carry
        signals = signals_of(position, velocity, reference, jnp.floor)
        (command,), memory = controller.step(LANES, gains, memory, View((signals,)))
        moved = drive(position, velocity, jnp.clip(command, -128, 127))
        return (memory, *moved), command

    every = jax.vmap(sample, in_axes=(0, 0, None))

    def body(carry, reference):
        return every(jax.tree.map(nested, gains), carry, reference)

    return lax.scan(body, start, references)[1]


def five(gains):
    """A population of five that are alike, for which a population of five has been compiled."""
    return jax.tree.map(lambda leaf: np.repeat(leaf, 5, axis=-1), gains)
