"""What ``hfc identify`` shows."""

import json
from pathlib import Path

import click

from hfc_design.core.console import plain_table, show_whole
from hfc_design.identify import words
from hfc_design.identify.result import Identified


def tell(found: Identified, path: Path, as_json: bool) -> None:
    """Show what was found."""
    if as_json:
        click.echo(json.dumps(found.numbers(), indent=1))
        return
    table = plain_table()
    for k, head in enumerate(words.HEADS):
        table.add_column(head, justify="left" if k < 2 else "right", no_wrap=k == 0)
    for row in words.parameter_rows(found):
        table.add_row(*(cell.replace("–", "-") for cell in row))
    show_whole(table, 2)
    click.echo(words.interval_line(found))
    click.echo()
    checks = plain_table()
    for head in ("log", "replayed in", "rms before", "rms after"):
        checks.add_column(head, justify="right" if head.startswith("rms") else "left")
    for row in words.check_rows(found):
        checks.add_row(*(cell.replace("µ", "u") for cell in row))
    show_whole(checks, 2)
    click.echo()
    click.echo(words.agreeing_line(found))
    for line in (*words.untold_lines(found), *found.notes):
        click.echo(line)
    if line := words.advice_line(found):
        click.echo(f"record next: {line.replace('µ', 'u').replace('±', '+-')}")
    click.echo(path)
