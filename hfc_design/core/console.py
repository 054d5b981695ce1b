"""Output to the terminal: text is shown as it is, since brackets hold units and are not markup."""

import re
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from textwrap import fill
from typing import Any, NamedTuple, Self

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console
from rich.live import Live
from rich.progress import Progress, ProgressColumn, Task
from rich.spinner import Spinner
from rich.table import Column
from rich.table import Table as Grid
from rich.text import Text

from hfc_design.core.records import harmless
from hfc_design.core.tables import Table

#: A terminal that claims fewer columns than the first number is taken to have the second.
NARROWEST, USUAL = 20, 80
#: Least number of columns of a terminal -> characters of its progress bar.
BARS = {60: 10, 100: 20}
#: Interval of the lines that are printed if there is no progress bar [s].
EVERY = 5.0
#: Least width of a last column of words [characters].
LEAST = 16
#: A part of a column's head that stays in one line.
WORD = re.compile(r"[^\s-]+-*|-+")
#: Letters that some terminals lack, and what is shown for them.
PLAIN = str.maketrans({"–": "-", "µ": "u", "±": "+-", "∞": "inf"})


def terminal(stderr: bool = False) -> Console:
    """Console for standard output, or for standard error."""
    console = Console(stderr=stderr, markup=False, emoji=False)
    if console.width < NARROWEST:  # COLUMNS=0, as some shells and editors have it
        console.width = USUAL
    return console


def room() -> int:
    """Return the width of a line of text [characters]: that of the terminal, 80 at most."""
    return min(terminal().width, 80)


def busy(what: str) -> AbstractContextManager[object]:
    """Show the text ``what`` and a spinner while work is done; on a terminal only."""
    console = terminal(stderr=True)
    if not console.is_terminal:
        return nullcontext()
    # Rich must not redirect what is printed meanwhile, which may go to a pipe.
    no_redirect: dict[str, Any] = {"redirect_stdout": False, "redirect_stderr": False}
    return Live(Spinner("line", what), console=console, transient=True, **no_redirect)


class Fitting(ProgressColumn):
    """A line of progress: count, bar, as many parts of the text ``line`` as fit, and time left."""

    def __init__(self, console: Console):
        super().__init__(Column(no_wrap=True))
        self._console = console

    def render(self, task: Task) -> Text:
        """Return the line, for the width of the terminal."""
        width = self._console.width
        first = f"{task.description} {task.completed:.0f}/{task.total or 0:.0f}"
        last = f"{_clock(task.time_remaining)} left"
        if task.finished:
            last = f"{_clock(task.elapsed)} in all"
        room = width - len(first) - len(last) - 3  # a blank stays free at the end
        line = Text(first)
        length = max((most for narrow, most in BARS.items() if width >= narrow), default=0)
        if room >= length + 2 > 2:
            dash = "-" if self._console.options.ascii_only else "━"
            line.append("  ").append_text(_bar(task, length, dash))
            room -= length + 2
        for part in filter(None, str(task.fields["line"]).split("  ")):
            if len(part) + 2 > room:
                break
            line.append(f"  {part}")
            room -= len(part) + 2
        return line.append(f"  {last}")


def _bar(task: Task, length: int, dash: str) -> Text:
    done = round(length * min(task.completed / task.total, 1.0)) if task.total else 0
    return Text.assemble((dash * done, "bar.complete"), (dash * (length - done), "bar.back"))


def _clock(seconds: float | None) -> str:
    """Return ``seconds`` as hours, minutes and seconds; dashes if they are unknown."""
    if seconds is None:
        return "-:--:--"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}"


class ProgressBar:
    """A progress bar if stderr is a terminal, else lines on stderr.

    The bar shows ``line`` too: parts separated by two blanks, the most important part first.
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
        """Update the bar: ``completed`` steps, ``description``, or the ``line`` after the count."""
        self._bar.update(self._task, **fields)

    def say(self, line: str) -> None:
        """Print a line if there is no bar."""
        if not self.console.is_terminal:
            print(line, file=sys.stderr)


class MachinesBar(ProgressBar):
    """Progress of the simulation of machines: a bar, or a line every ``EVERY`` seconds."""

    def __init__(self) -> None:
        super().__init__("compiling", 1, "machines")
        self._said = time.monotonic()

    def chunk(self, what: str, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` machines are finished; ``what`` is the work."""
        self.show(description=what, completed=done, total=total)
        if time.monotonic() - self._said > EVERY:
            self.say(f"{done}/{total} machines  {what}")
            self._said = time.monotonic()


def say(*lines: str) -> None:
    """Print texts in characters that every terminal has, wrapped to the width of the terminal."""
    for line in lines:
        print(fill(_plain(line), room(), break_on_hyphens=False, break_long_words=False))


def _plain(text: str) -> str:
    lines = (harmless(line) for line in text.split("\n"))
    return "\n".join(lines).translate(PLAIN)


def show(*tables: Table) -> None:
    """Print tables: of each the title above or the caption below, its columns, its lines.

    No cell is cut: the first column is wrapped if that helps, and a last column of words takes the
    rest of the width. Columns that do not fit are printed in further tables below. Each of these
    begins with the first column (or the first two, of words), then at most half the width wide.
    """
    for k, table in enumerate(one for one in tables if one.rows or one.lines):
        if k:
            print()
        if table.rows:
            if table.title:
                say(table.title)
            _show_columns(table)
            if not table.title and table.caption:
                say(table.caption)
        say(*table.lines)


class _Column(NamedTuple):
    """A column of a table at a terminal."""

    head: str
    numeric: bool
    cells: list[Text]
    width: int


def _columns(table: Table) -> Iterator[_Column]:
    best = table.best or [()] * len(table.rows)
    for k, (head, numeric) in enumerate(zip(table.head, table.numeric, strict=True)):
        blank, cells = "  " * any(k in places for places in best), []
        for row, places in zip(table.rows, best, strict=True):
            mark, style = (" *", "bold") if k in places else (blank, "")
            cells.append(Text(_plain(row[k]) + mark, style))
        lines = [line for cell in cells for line in cell.plain.split("\n")]
        yield _Column(_plain(head), numeric, cells, max(map(cell_len, [*lines, _plain(head)])))


def _narrow(column: _Column) -> _Column:
    """Return the column with its head wrapped to the width of its cells."""
    lines = [line for cell in column.cells for line in cell.plain.split("\n")]
    width = max(map(cell_len, [*lines, *WORD.findall(column.head)]), default=1)
    return column._replace(head=fill(column.head, width), width=width)


def _show_columns(table: Table) -> None:
    console, columns = terminal(), [*_columns(table)]
    if _wide(columns) > console.width:
        columns = [*map(_narrow, columns)]
    words = [word for cell in columns[0].cells for word in cell.plain.split()]
    room = console.width - _wide(columns[1:]) - 1
    if columns[0].width > room >= max(map(cell_len, words), default=0):
        columns[0] = columns[0]._replace(width=room)
    first = 2 if len(columns) > 2 and not columns[1].numeric else 1
    most = console.width // (2 * first) if _wide(columns) > console.width else console.width
    last, rest = columns[-1], console.width - _wide(columns[:-1]) - 1
    if not last.numeric and last.width > rest >= LEAST:
        columns[-1], most = last._replace(width=rest), console.width
    leading = [one._replace(width=min(one.width, most)) for one in columns[:first]]
    others = columns[first:]
    while others:
        count = len(others)
        while count > 1 and _wide(leading + others[:count]) > console.width:
            count -= 1
        console.print(_grid(leading + others[:count]))
        others = others[count:]
        if others:
            print()


def _wide(columns: Sequence[_Column]) -> int:
    return sum(one.width for one in columns) + len(columns) - 1


def _grid(columns: Sequence[_Column]) -> Grid:
    head = any(one.head for one in columns)
    grid = Grid(box=SIMPLE_HEAD, show_edge=False, padding=0, show_header=head)
    for one in columns:
        side: Any = "right" if one.numeric else "left"
        grid.add_column(Text(one.head), justify=side, overflow="fold", width=one.width)
    for row in zip(*(one.cells for one in columns), strict=True):
        grid.add_row(*row)
    return grid
