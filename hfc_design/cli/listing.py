"""``hfc list``."""

import click


@click.command("list")
@click.argument(
    "what", type=click.Choice(["scenarios", "designs", "plants", "controllers", "formats"])
)
def list_(what: str) -> None:
    """What is built in."""
    from rich.table import Table

    from hfc_design import controllers, evaluate, rulebase, scenarios
    from hfc_design.console import terminal
    from hfc_design.export import FORMATS
    from hfc_design.laws.law import LAWS
    from hfc_design.machine_settings import ALL_PLANTS

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
