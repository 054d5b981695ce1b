"""What commands share: the help of --set, and the design on its scenario."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hfc_design.rulebase import Design
    from hfc_design.scenarios import Scenario

SET_HELP = "Change a value of the scenario by its dotted key, as in simulation.duration_s=5."


def loaded(
    name: str, scenario: str | None, chosen: dict[str, str], changes: tuple[str, ...]
) -> "tuple[Design, Scenario]":
    """The design ``name`` and the scenario it runs on: ``scenario``, or its own.

    ``chosen`` is what ``choosing_plugins`` gives.

    Raises:
        UserError: there is no such design or scenario, or a change is not allowed.
    """
    from hfc_design.evaluate import load_design, own_scenario
    from hfc_design.scenarios import load_scenario

    found = load_design(name)
    # The controller is the design's, whatever a search of the scenario would vary.
    plugins = (change for key, change in chosen.items() if key != "controller")
    changes = (*plugins, *changes)
    if scenario is not None:
        return found, load_scenario(scenario, changes)
    return found, own_scenario(found, name, changes)
