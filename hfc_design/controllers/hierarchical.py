"""PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999, section 3.2)."""

from functools import cache
from typing import Any, NamedTuple

import jax.numpy as jnp

from hfc_design.controllers import pd
from hfc_design.controllers.controller import Controller
from hfc_design.fuzzy import LIN_LEE_TERMS, Term, infer
from hfc_design.hierarchy import picked

#: An input of this prefix is the reading of the previous sample, 0 at the first one.
PREVIOUS = "previous_"


class Layout(NamedTuple):
    """What the search leaves alone: which inputs, how they are scaled, which terms they have.

    The defaults are those of Lin & Lee 1999, section 4.
    """

    inputs: tuple[str, ...] = (
        "error",
        "deflection",
        "deflection_rate",
        "spindle_velocity",
        "previous_spindle_velocity",
    )
    scales: tuple[float, ...] = (50.0, 80.0, 20.0, 20.0, 10.0)  # k_1 .. k_5
    output_scale: float = 10.0  # k_6 [V]
    terms: tuple[Term, ...] = LIN_LEE_TERMS


class HierarchicalGains(NamedTuple):
    """What the search changes: one individual, or a population in the trailing axis."""

    kp: Any  # [V/rad]
    kd: Any  # [V s/rad]
    scales: Any  # (inputs,) k_1, k_2, ..., per unit of the input
    sources: Any  # (units, 2) column and row source of each unit, see ``hierarchy.Tree``
    consequents: Any  # (units, 7, 7) singletons, [unit][row term][column term]


@cache
def hierarchical(layout: Layout) -> Controller:
    """The controller of kind ``pd+hierarchical-fuzzy``.

    The scaled external inputs are clamped to [-1, 1]; the outputs of inner units are not,
    because published consequents lie outside that range.
    """
    remembered = tuple(
        name.removeprefix(PREVIOUS) for name in layout.inputs if name.startswith(PREVIOUS)
    )

    def step(gains: HierarchicalGains, memory: Any, signals: dict[str, Any]) -> tuple[Any, Any]:
        known = signals | {f"{PREVIOUS}{name}": memory[name] for name in remembered}
        values = [
            jnp.clip(scale * known[name], -1.0, 1.0)
            for name, scale in zip(layout.inputs, gains.scales, strict=True)
        ]
        for (column, row), consequents in zip(gains.sources, gains.consequents, strict=True):
            values.append(
                infer(layout.terms, consequents, picked(values, column), picked(values, row))
            )
        command = pd.law(gains, signals) + layout.output_scale * values[-1]
        return command, {name: signals[name] for name in remembered}

    return Controller("pd+hierarchical-fuzzy", lambda zero: dict.fromkeys(remembered, zero), step)
