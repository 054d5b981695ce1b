"""``hfc list``."""

import click

from hfc_design.cli.options import knowing_plugins

LISTED = "scenarios", "designs", "plants", "controllers", "fitnesses", "strategies", "formats"


@click.command("list")
@click.argument("what", type=click.Choice(LISTED))
@knowing_plugins
def list_(what: str) -> None:
    """What is built in."""
    from rich.table import Table

    from hfc_design.controllers.kinds import KINDS
    from hfc_design.core.console import terminal
    from hfc_design.files import design as rulebase
    from hfc_design.files import scenario as scenarios
    from hfc_design.files.machine import ALL_PLANTS
    from hfc_design.formats import FORMATS
    from hfc_design.objectives.judge import OBJECTIVES
    from hfc_design.search.loop import STRATEGIES
    from plants import Machine

    if what == "scenarios":
        names = scenarios.builtin_names()
        lines = {name: scenarios.load_scenario(name).description for name in names}
    elif what == "designs":
        names = rulebase.builtin_designs()
        lines = {name: str(rulebase.named_design(name).provenance["source"]) for name in names}
    elif what == "plants":
        lines = {}
        for name in ALL_PLANTS.names():
            plant = ALL_PLANTS.get(name)
            if isinstance(plant, Machine):
                pairs = zip(plant.axes, plant.drives, strict=True)
                lines[name] = ", ".join(f"{axis}: {drive.name}" for axis, drive in pairs)
            else:
                lines[name] = ", ".join(plant.parameters._fields)
    elif what == "controllers":
        lines = {name: KINDS.get(name).summary for name in KINDS.names()}
    elif what == "fitnesses":
        lines = {name: OBJECTIVES.get(name).meaning for name in OBJECTIVES.names()}
    elif what == "strategies":
        lines = {name: STRATEGIES.get(name).summary for name in STRATEGIES.names()}
    else:
        lines = {name: found.text for name, found in FORMATS.items()}
    table = Table(box=None, show_header=False)
    for name, text in lines.items():
        table.add_row(name, text)
    terminal().print(table)
