"""The terminal: text is shown as it is, since brackets hold units and are no markup."""

import sys
from typing import Any, Self

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table


def terminal(stderr: bool = False) -> Console:
    """Standard output, or standard error."""
    return Console(stderr=stderr, markup=False, emoji=False)


class ProgressBar:
    """A bar on a terminal, lines elsewhere; both on stderr."""

    def __init__(self, task: str, total: int, line: str = ""):
        self.console = terminal(stderr=True)
        self.total = total
        self._bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=20),
            TextColumn("{task.completed:.0f}/{task.total:.0f} {task.fields[line]}", markup=False),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=self.console,
            disable=not self.console.is_terminal,
        )
        self._task = self._bar.add_task(task, total=total, line=line)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def show(self, **fields: Any) -> None:
        """Change the bar: ``completed``, ``description``, or the ``line`` behind its counts."""
        self._bar.update(self._task, **fields)

    def say(self, line: str) -> None:
        """A line where there is no bar."""
        if not self.console.is_terminal:
            print(line, file=sys.stderr)


def plain_table(**options: Any) -> Table:
    """A table whose columns a space separates, so that eight of them fit into 80 characters."""
    return Table(title_justify="left", box=SIMPLE_HEAD, show_edge=False, padding=0, **options)
