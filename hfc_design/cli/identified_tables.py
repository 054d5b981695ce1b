"""What ``hfc identify`` shows."""

import json
from pathlib import Path

import click

from hfc_design.core.console import show_rows
from hfc_design.identify import words
from hfc_design.identify.result import Identified


def tell(found: Identified, path: Path, as_json: bool) -> None:
    """Show what was found."""
    if as_json:
        click.echo(json.dumps(found.numbers(), indent=1))
        return
    rows = ([cell.replace("–", "-") for cell in row] for row in words.parameter_rows(found))
    show_rows(words.HEADS, rows, 2, (0, 1))
    click.echo(words.interval_line(found))
    click.echo()
    rows = ([cell.replace("µ", "u") for cell in row] for row in words.check_rows(found))
    show_rows(("log", "replayed in", "rms before", "rms after"), rows, 2, (0, 1))
    click.echo()
    click.echo(words.agreeing_line(found))
    for line in (*words.untold_lines(found), *found.notes):
        click.echo(line)
    if line := words.advice_line(found):
        click.echo(f"record next: {line.replace('µ', 'u').replace('±', '+-')}")
    click.echo(path)
