"""The terminal: text is shown as it is, since brackets hold units and are no markup."""

from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import TextColumn
from rich.table import Table


def terminal(stderr: bool = False) -> Console:
    """Standard output, or standard error."""
    return Console(stderr=stderr, markup=False, emoji=False)


def column(text: str) -> TextColumn:
    """A column of a bar of progress, a format of its task."""
    return TextColumn(text, markup=False)


def plain_table(**options: Any) -> Table:
    """A table whose columns a space separates, so that eight of them fit into 80 characters."""
    return Table(title_justify="left", box=SIMPLE_HEAD, show_edge=False, padding=0, **options)
