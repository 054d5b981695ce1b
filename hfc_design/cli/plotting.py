"""The command that draws a design: surfaces, terms, rule tables, the hierarchy."""

from pathlib import Path

import click

from hfc_design.cli.options import Texts, changing_design, force, knowing_plugins, output

UNIT_HELP = "Unit of a hierarchy to draw, as unit-1 [default: the root]."


@click.command()
@click.argument("design")
@click.argument("what", metavar="WHAT")
@changing_design
@click.option("--unit", help=UNIT_HELP)
@click.option("--axis", default="", help="Of a controller with several: the axis to draw.")
@output("--out", required=True, help="The picture (png, svg or pdf).")
@force
@knowing_plugins
def plot(design: str, what: str, others: Texts, unit: str | None, axis: str, out: Path) -> None:
    """Draw what a DESIGN is: its surface, terms, tables or tree.

    WHAT is surface or surface-3d: the output of a fuzzy unit over its two inputs, as colours or in
    space; terms: their degrees; tables: its rules as colours with the names of the terms; tree:
    which unit reads what. Of a controller with others inside, those are drawn.
    """
    from hfc_design.files.pairing import load_design
    from hfc_design.pictures.files import save
    from hfc_design.report.designs import picture

    save(picture(load_design(design, others), what, unit, axis), out)
    click.echo(out)
