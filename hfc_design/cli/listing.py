"""``hfc list``."""

import click


@click.command("list")
@click.argument(
    "what", type=click.Choice(["scenarios", "designs", "plants", "controllers", "formats"])
)
def list_(what: str) -> None:
    """What is built in."""
    from rich.table import Table

    from hfc_design.controllers import kinds as controllers
    from hfc_design.controllers.gains.law import LAWS
    from hfc_design.core.console import terminal
    from hfc_design.files import design as rulebase
    from hfc_design.files import scenario as scenarios
    from hfc_design.files.machine import ALL_PLANTS
    from hfc_design.formats import FORMATS
    from hfc_design.simulation import evaluation as evaluate

    if what == "scenarios":
        names = scenarios.builtin_names()
        lines = {name: scenarios.load_scenario(name).description for name in names}
    elif what == "designs":
        names = rulebase.builtin_designs()
        lines = {name: str(evaluate.load_design(name).provenance["source"]) for name in names}
    elif what == "plants":
        plants = {name: ALL_PLANTS.get(name) for name in ALL_PLANTS.names()}
        lines = {name: ", ".join(plant.parameters._fields) for name, plant in plants.items()}
    elif what == "controllers":
        lines = dict.fromkeys(LAWS.names(), "an own law") | controllers.KINDS
    else:
        lines = {name: text for name, (text, _) in FORMATS.items()}
    table = Table(box=None, show_header=False)
    for name, text in lines.items():
        table.add_row(name, text)
    terminal().print(table)
