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

#: Number of machines that are sorted by their sliding friction, the same in all runs.
RUBBING = 199


def drawn_for(scenario: Scenario, count: int, seed: int, margin: float = 1.0) -> Machines:
    """The nominal machine of a robust scenario and ``count`` others within its tolerances.

    The tolerances are widened by the factor ``margin``.
    """
    robust = scenario.robust
    assert robust is not None
    even = robust.sample == "latin-hypercube"
    wider = {name: margin * spread for name, spread in robust.tolerances.items()}
    parts = (scenario.plant, margin * robust.spread, count, seed, wider, even)
    return drawn(*parts, key="robust.spread")[0]


def margin_limits(scenario: Scenario, loop: Loop, genome: Any, final: bool) -> AskedMargins | None:
    """Margins that the scenario requires of the linearised loop; None: it requires none.

    ``final`` selects those of finalists. A robust scenario requires at least stability, if it can
    be determined for such laws.
    """
    if not scenario.margins and not scenario.robust:
        return None
    with suppress(*[UserError] * (not scenario.margins)):
        limits = AskedMargins(scenario, loop, _with_stress_friction(scenario), final)
        limits.broken(genome.gains(genome.empty()))
        return limits
    return None


def _with_stress_friction(scenario: Scenario) -> Machines | None:
    """Machines within the tolerances with the friction of the stress; None: none is required."""
    if not (scenario.robust and scenario.margins) or scenario.stress.friction <= 1.0:
        return None
    machines = drawn_for(scenario, RUBBING, 0)
    return rubbing(scenario, machines, Applied(friction=scenario.stress.friction))
