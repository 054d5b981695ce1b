"""PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999, section 3.2)."""

from functools import cache
from typing import Any, NamedTuple

import jax.numpy as jnp

from hfc_design.controllers.controller import Controller
from hfc_design.controllers.hierarchical import root as root_unit
from hfc_design.controllers.hierarchical.tree import picked
from hfc_design.controllers.hierarchical.unit import (
    LIN_LEE_TERMS,
    Term,
    averaged,
    infer,
    memberships,
)
from hfc_design.controllers.pd import controller as pd
from hfc_design.core.lanes import LANES

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
    adaptation: root_unit.Adaptation | None = None  # of the root's consequents; None: fixed


class HierarchicalGains(NamedTuple):
    """What the search changes: one individual, or a population in the trailing axis."""

    kp: Any  # [V/rad]
    kd: Any  # [V s/rad]
    scales: Any  # (inputs,) k_1, k_2, ..., per unit of the input
    sources: Any  # (units, 2) column and row source of each unit, see ``hierarchy.Tree``
    consequents: Any  # (units, 7, 7) singletons, [unit][row term][column term]


class HierarchicalMemory(NamedTuple):
    """What the controller remembers; all zero before the first sample."""

    readings: dict[str, Any]  # of the previous sample
    root: root_unit.RootMemory | None  # None: the root does not adapt


@cache
def hierarchical(layout: Layout) -> Controller:
    """The controller of kind ``pd+hierarchical-fuzzy``.

    The scaled external inputs are clamped to [-1, 1]; the outputs of inner units are not,
    because published consequents lie outside that range.
    """
    adaptation = layout.adaptation
    remembered = tuple(
        name.removeprefix(PREVIOUS) for name in layout.inputs if name.startswith(PREVIOUS)
    )

    def initial_memory(zero: Any) -> HierarchicalMemory:
        root = root_unit.initial_memory(zero) if adaptation else None
        return HierarchicalMemory(dict.fromkeys(remembered, zero), root)

    def step(
        gains: HierarchicalGains, memory: HierarchicalMemory, signals: dict[str, Any]
    ) -> tuple[Any, HierarchicalMemory]:
        known = signals | {f"{PREVIOUS}{name}": memory.readings[name] for name in remembered}
        values = [
            jnp.clip(scale * known[name], -1.0, 1.0)
            for name, scale in zip(layout.inputs, gains.scales, strict=True)
        ]
        *inner, top = zip(gains.sources, gains.consequents, strict=True)
        for (column, row), consequents in inner:
            values.append(
                infer(layout.terms, consequents, picked(values, column), picked(values, row))
            )
        (column, row), consequents = top
        seen = picked(values, column), picked(values, row)
        in_column, in_row = (memberships(layout.terms, u) for u in seen)
        root = None
        if adaptation and memory.root:
            in_error = memberships(layout.terms, graded(gains, signals["error"]))
            consequents, root = root_unit.step(
                LANES, adaptation, consequents, memory.root, in_error, in_column, in_row
            )
        output = averaged(consequents, in_column, in_row)
        command = pd.law(gains, signals) + layout.output_scale * output
        return command, HierarchicalMemory({name: signals[name] for name in remembered}, root)

    def graded(gains: HierarchicalGains, error: Any) -> Any:
        """The error on the universe of the terms."""
        scale = adaptation.error_scale if adaptation else None
        if scale is None:
            scale = gains.scales[layout.inputs.index("error")]
        return jnp.clip(scale * error, -1.0, 1.0)

    return Controller("pd+hierarchical-fuzzy", initial_memory, step)
