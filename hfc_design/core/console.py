"""Output to the terminal: text is shown as it is, since brackets hold units and are not markup."""

import sys
from collections.abc import Container, Iterable
from contextlib import AbstractContextManager, nullcontext
from copy import copy
from typing import Any, Self

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.live import Live
from rich.progress import Progress, ProgressColumn, Task
from rich.spinner import Spinner
from rich.table import Column, Table
from rich.text import Text

#: Columns of a terminal; fewer than the first are none, and the second are taken.
NARROWEST, USUAL = 20, 80
#: Columns of a terminal -> letters of its bar.
BARS = {60: 10, 100: 20}


def terminal(stderr: bool = False) -> Console:
    """Console for standard output, or for standard error."""
    console = Console(stderr=stderr, markup=False, emoji=False)
    if console.width < NARROWEST:  # COLUMNS=0, as some shells and editors have it
        console.width = USUAL
    return console


def room() -> int:
    """Number of characters in a line of text: the width of the terminal, 80 at most."""
    return min(terminal().width, 80)


def busy(what: str) -> AbstractContextManager[object]:
    """Show on a terminal what takes a while without countable steps; nothing elsewhere."""
    console = terminal(stderr=True)
    if not console.is_terminal:
        return nullcontext()
    # What is printed meanwhile stays where it goes, a pipe perhaps.
    no_redirect: dict[str, Any] = {"redirect_stdout": False, "redirect_stderr": False}
    return Live(Spinner("dots", what), console=console, transient=True, **no_redirect)


class Fitting(ProgressColumn):
    """Progress text for a line: the count, the time left, then as much of the rest as fits."""

    def __init__(self, console: Console):
        super().__init__(Column(no_wrap=True))
        self._console = console

    def render(self, task: Task) -> Text:
        """The line."""
        width = self._console.width
        first = f"{task.description} {task.completed:.0f}/{task.total or 0:.0f}"
        last = f"{_clock(task.time_remaining)} left"
        if task.finished:
            last = f"{_clock(task.elapsed)} in all"
        room = width - len(first) - len(last) - 3  # a blank stays free at the end
        line = Text(first)
        length = max((most for narrow, most in BARS.items() if width >= narrow), default=0)
        if room >= length + 2 > 2:
            line.append("  ").append_text(_bar(task, length))
            room -= length + 2
        for part in filter(None, str(task.fields["line"]).split("  ")):
            if len(part) + 2 > room:
                break
            line.append(f"  {part}")
            room -= len(part) + 2
        return line.append(f"  {last}")


def _bar(task: Task, length: int) -> Text:
    done = round(length * min(task.completed / task.total, 1.0)) if task.total else 0
    return Text.assemble(("━" * done, "bar.complete"), ("━" * (length - done), "bar.back"))


def _clock(seconds: float | None) -> str:
    """Hours, minutes and seconds; dashes where nobody knows yet."""
    if seconds is None:
        return "-:--:--"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}"


class ProgressBar:
    """A bar on a terminal, lines elsewhere; both on stderr.

    ``line`` is shown beside it, the most important parts first, separated by two blanks.
    """

    def __init__(self, task: str, total: int, line: str = ""):
        self.console = terminal(stderr=True)
        self.total = total
        self._bar = Progress(
            Fitting(self.console), console=self.console, disable=not self.console.is_terminal
        )
        self._task = self._bar.add_task(task, total=total, line=line)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def show(self, **fields: Any) -> None:
        """Update the bar: ``completed``, ``description``, or the ``line`` behind its counts."""
        self._bar.update(self._task, **fields)

    def say(self, line: str) -> None:
        """Print a line if there is no bar."""
        if not self.console.is_terminal:
            print(line, file=sys.stderr)


def plain_table(**options: Any) -> Table:
    """A table with a space between columns, so that eight of them fit into 80 characters."""
    return Table(title_justify="left", box=SIMPLE_HEAD, show_edge=False, padding=0, **options)


def show_rows(
    heads: Iterable[str],
    rows: Iterable[Iterable[str | Text]],
    leading: int = 1,
    left: Container[int] = (0,),
    **options: Any,
) -> None:
    """Print rows with ``show_whole``; columns hold numbers except for the ``left`` ones."""
    table = plain_table(**options)
    for k, head in enumerate(heads):
        table.add_column(head, justify="left" if k in left else "right")
    for row in rows:
        table.add_row(*row)
    show_whole(table, leading)


def show_whole(table: Table, leading: int = 1) -> None:
    """Print a table without cutting a number.

    Columns that do not fit beside the first ``leading`` ones are printed in further tables below.
    The leading columns may be wrapped and take half of the width.
    """
    console, others = terminal(), [*range(leading, len(table.columns))]
    whole = _part(table, [*range(leading), *others], leading, None)
    most = None if _fits(whole, console) else console.width // (2 * leading)
    while others:
        count = len(others)
        part = _part(table, [*range(leading), *others[:count]], leading, most)
        while count > 1 and not _fits(part, console):
            count -= 1
            part = _part(table, [*range(leading), *others[:count]], leading, most)
        part.title = table.title if others[0] == leading else None
        part.caption = table.caption if count == len(table.columns) - leading else None
        others = others[count:]
        console.print(part)
        if others:
            console.print()
        elif part.caption is None and table.caption:  # the last table may be narrow
            console.print(table.caption, style="table.caption")


def _fits(table: Table, console: Console) -> bool:
    endless = console.options.update(max_width=10_000)
    return console.measure(table, options=endless).maximum <= console.width


def _part(table: Table, places: list[int], leading: int, most: int | None) -> Table:
    """A table of some of the columns; the first ``leading`` have so many letters at most."""
    part = copy(table)
    part.columns, part.rows = [], []
    columns = [table.columns[k] for k in places]
    for k, column in enumerate(columns):
        options: dict[str, Any] = {"justify": column.justify, "no_wrap": True}
        if k < leading:
            options |= {"no_wrap": False, "overflow": "fold", "max_width": most}
        part.add_column(column.header, **options)
    rows = zip(*(column.cells for column in columns), strict=True)
    for cells, row in zip(rows, table.rows, strict=True):
        part.add_row(*cells, style=row.style, end_section=row.end_section)
    return part
