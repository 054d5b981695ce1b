"""What commands share: --set, --change, and the design on its scenario."""

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario

SET_HELP = "Change a value of the scenario by its dotted key, as in simulation.duration_s=5."
#: Of every command on a design.
changing_design = click.option(
    "--change",
    "others",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change a value of the design by its dotted key, as in controller.integral_gain=8.",
)


def loaded(
    name: str,
    others: tuple[str, ...],
    scenario: str | None,
    chosen: dict[str, str],
    changes: tuple[str, ...],
) -> "tuple[Design, Scenario]":
    """The design ``name`` with ``others`` changed, and the scenario that it runs on.

    That is ``scenario`` or the design's own, with ``changes``; ``chosen`` is what
    ``choosing_plugins`` gives.

    Raises:
        UserError: there is no such design or scenario, or a change is not allowed.
    """
    from hfc_design.files.pairing import load_design, own_scenario
    from hfc_design.files.scenario import load_scenario

    found = load_design(name, others)
    # The controller is the design's, whatever a search of the scenario would vary.
    plugins = (change for key, change in chosen.items() if key != "controller")
    changes = (*plugins, *changes)
    if scenario is not None:
        return found, load_scenario(scenario, changes)
    return found, own_scenario(found, name, changes)
