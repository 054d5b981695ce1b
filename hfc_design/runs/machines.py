"""Machines of a search, and the margins that it requires of their loops."""

from contextlib import suppress
from typing import Any

from hfc_design.core.records import UserError
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.closed_loop import Loop
from hfc_design.simulation.loop_margins import AskedMargins
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import Machines
from hfc_design.simulation.stress import Applied, rubbing

#: Number of machines with the friction of the stress; they are the same in all runs.
RUBBING = 199


def drawn_for(scenario: Scenario, count: int, seed: int, margin: float = 1.0) -> Machines:
    """Return the nominal machine of a robust scenario and ``count`` others within its tolerances.

    The tolerances are widened by the factor ``margin``.
    """
    robust = scenario.robust
    assert robust is not None
    even = robust.sample == "latin-hypercube"
    wider = {name: margin * spread for name, spread in robust.tolerances.items()}
    parts = (scenario.plant, margin * robust.spread, count, seed, wider, even)
    return drawn(*parts, key="robust.spread")[0]


def margin_limits(scenario: Scenario, loop: Loop, genome: Any, final: bool) -> AskedMargins | None:
    """Return the margins that the scenario requires of the linearised loop; None: it requires none.

    With ``final``, they are those for finalists. A robust scenario requires at least stability, if
    the stability of such laws can be determined.
    """
    if not scenario.margins and not scenario.robust:
        return None
    with suppress(*[UserError] * (not scenario.margins)):
        limits = AskedMargins(scenario, loop, _with_stress_friction(scenario), final)
        limits.broken(genome.gains(genome.empty()))
        return limits
    return None


def _with_stress_friction(scenario: Scenario) -> Machines | None:
    """Return machines within the tolerances with the stress friction; None: not needed."""
    if not (scenario.robust and scenario.margins) or scenario.stress.friction <= 1.0:
        return None
    machines = drawn_for(scenario, RUBBING, 0)
    return rubbing(scenario, machines, Applied(friction=scenario.stress.friction))
