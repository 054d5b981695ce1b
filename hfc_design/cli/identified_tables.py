"""What ``hfc identify`` writes and shows."""

import shlex
import sys
from pathlib import Path

import click

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.console import plain_table, show_whole
from hfc_design.core.records import writing
from hfc_design.identify import aim, page
from hfc_design.identify.identified import Identified
from hfc_design.report import REPORT


def write(found: Identified, log: str, path: Path, from_file: bool) -> None:
    """Write the folder.

    Raises:
        UserError, RunError: it cannot be written, or is not what a scenario can hold.
    """
    command = shlex.join(["hfc", *sys.argv[1:]])
    texts = {
        "scenario.toml": aim.scenario_text(found, log, from_file).encode(),
        "identified.json": page.record(found, log).encode(),
        REPORT: page.page(found, log, command).html,
    }
    with writing(path):
        path.mkdir(parents=True, exist_ok=True)
    for name, content in texts.items():
        write_whole(path / name, content)


def tell(found: Identified, log: str, path: Path, as_json: bool) -> None:
    """Show what was found."""
    if as_json:
        click.echo(page.record(found, log), nl=False)
        return
    table = plain_table()
    for k, head in enumerate(page.HEADS):
        table.add_column(head, justify="left" if k < 2 else "right", no_wrap=k == 0)
    for row in page.parameter_rows(found):
        table.add_row(*(cell.replace("–", "-") for cell in row))
    show_whole(table, 2)
    click.echo(page.interval_line(found))
    click.echo()
    checks = plain_table()
    for head in ("log", "replayed in", "rms before", "rms after"):
        checks.add_column(head, justify="right" if head.startswith("rms") else "left")
    for row in page.check_rows(found):
        checks.add_row(*(cell.replace("µ", "u") for cell in row))
    show_whole(checks, 2)
    click.echo()
    click.echo(page.agreeing_line(found))
    for line in (*page.untold_lines(found), *found.notes):
        click.echo(line)
    if line := page.advice_line(found):
        click.echo(f"record next: {line.replace('µ', 'u').replace('±', '+-')}")
    click.echo(path)
