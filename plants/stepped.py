"""Whether the step of a drive gives back the record that it was given, before anything is run."""

from typing import Any

import jax
from jax import numpy as jnp

from plants.drive import Drive, called


def step_fault(drive: Drive) -> str | None:
    """What is wrong with what a step returns, in a line; None if nothing, or if it raises.

    What it raises is told where it is simulated, with the line of the user's code.
    """
    fixed = called(drive, "coefficients", drive.parameters())
    before = called(drive, "initial_state", 0.0)
    if not hasattr(before, "_fields"):
        return "initial_state has to give a NamedTuple"
    try:
        after = jax.eval_shape(drive.step, fixed, before, 0.0, (0.0, 0.0, 0.0), 1e-3)
    except Exception:  # whatever the user's code raises
        return None
    if type(after) is not type(before):
        wrong = f"it returns {_kind(after)}"
    else:
        values = {name: getattr(after, name) for name in before._fields}
        each = [f"{name} is {_kind(x)}" for name, x in values.items() if not _is_float(x)]
        wrong = ", ".join(each)
    fields = ", ".join(before._fields)
    told = f"step has to return the record {type(before).__name__} with {fields}, each a float"
    return f"{told}: {wrong}" if wrong else None


def _is_float(value: Any) -> bool:
    return hasattr(value, "dtype") and jnp.issubdtype(value.dtype, jnp.floating)


def _kind(value: Any) -> str:
    """What it is instead."""
    if value is None:
        return "None"
    return str(value.dtype) if hasattr(value, "dtype") else f"a {type(value).__name__}"
