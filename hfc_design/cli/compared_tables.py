"""Tables of a comparison at a terminal, and its progress."""

import time
from math import ceil

from rich.text import Text

from hfc_design.core.console import ProgressBar, plain_table, show_rows, terminal
from hfc_design.report.comparison.tables import called, difference_row, failures, lines
from hfc_design.simulation.comparison import Comparison, MotionComparison, spread_text

#: Heads of the columns of a difference that fit a terminal.
HEAD = ("", "median ratio", "better on", "p\n(Holm)", "both\nstable")
#: Widths of the names of metrics and machines, and smallest width for a design.
NAMES, NARROWEST = 34, 14
#: Interval of the lines without a progress bar [s].
EVERY = 5.0


class Progress(ProgressBar):
    """Progress of the simulated machines."""

    def __init__(self) -> None:
        super().__init__("compiling", 1, "machines")
        self._said = time.monotonic()

    def chunk(self, what: str, done: int, total: int) -> None:
        """Show the number of finished machines."""
        self.show(description=what, completed=done, total=total)
        if time.monotonic() - self._said > EVERY:
            self.say(f"{done}/{total} machines  {what}")
            self._said = time.monotonic()


def show(comparison: Comparison) -> None:
    """Print tables of every motion, then the differences of the first design from the others."""
    console = terminal()
    for bout in comparison.bouts:
        _show_lines(comparison, bout)
    console.print("* the best of a row; an unstable machine ranks below all others\n")
    first = next(iter(comparison.designs))
    for bout in comparison.bouts:
        keys = bout.compared()
        for key in (keys[0], *(key for key in keys if "_change" in key)):
            title = f"{bout.name}, {called(bout, key)}: {first} over"
            rows = (
                [one.second, *difference_row(one)[: len(HEAD) - 1]]
                for one in comparison.of(bout.name, key)
                if one.first == first
            )
            show_rows(HEAD, rows, title=title, title_style="")
            console.print()
    for text in (*failures(comparison), *comparison.notes):
        console.print(text, style="", soft_wrap=True)


def _show_lines(comparison: Comparison, bout: MotionComparison) -> None:
    console, machines = terminal(), f"{comparison.machines} machines within {comparison.within}"
    robust = bout.scenario.robust if bout.scenario else None
    if robust and (within := spread_text(robust.spread, robust.tolerances)) != comparison.within:
        machines += f" ([robust]: {within})"
    count, most = len(comparison.designs), max((console.width - NAMES) // NARROWEST, 1)
    at_once = ceil(count / ceil(count / most))
    for start in range(0, count, at_once):
        table = plain_table(title=f"{bout.name}, {machines}", title_style="")
        table.add_column("metric", no_wrap=True)
        table.add_column("machine", no_wrap=True)
        for name in [*comparison.designs][start : start + at_once]:
            table.add_column(name, justify="right", overflow="fold", min_width=NARROWEST - 1)
        for line in lines(bout):
            cells = [
                Text(f"{cell} *", "bold") if k in line.best else f"{cell}  "
                for k, cell in enumerate(line.cells)
            ]
            table.add_row(line.metric, line.of, *cells[start : start + at_once])
        console.print(table)
        console.print()
