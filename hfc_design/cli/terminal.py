"""What ``hfc design`` and ``hfc score`` both show: a bar of progress, a table of metrics."""

from rich.console import Console
from rich.progress import BarColumn, Progress, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from hfc_design.core.console import column, terminal
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.evaluation import Evaluation


def show_table(scenario: Scenario, rows: dict[str, Evaluation], caption: str = "") -> None:
    """Fitness, merit and metrics of some designs side by side, one column a design."""
    table = Table(caption=caption or None, caption_justify="left")
    table.add_column("metric", no_wrap=True)
    for name in rows:
        table.add_column(name, justify="right", overflow="fold")
    for key, title in scenario.judge().titles.items():
        scores = (f"{getattr(r, key):.4f}" if not r.diverged else "diverged" for r in rows.values())
        table.add_row(title.replace(" / ", "\n/ "), *scores)
    first = next(iter(rows.values()))
    for key in first.metrics:
        found = (row.metrics[key] for row in rows.values())
        table.add_row(key, *("-" if value is None else f"{value:.5g}" for value in found))
    terminal().print(table)


def progress_bar(console: Console) -> Progress:
    """A progress bar on a terminal, else nothing; a task's ``line`` stands behind its counts."""
    return Progress(
        column("{task.description}"),
        BarColumn(bar_width=20),
        column("{task.completed:.0f}/{task.total:.0f} {task.fields[line]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=console,
        disable=not console.is_terminal,
    )
