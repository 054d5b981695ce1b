"""What a batch found, at a terminal: its groups, which are more than chance, its structures."""

from pathlib import Path

from rich.text import Text

from hfc_design.batch import structures
from hfc_design.batch.groups import ANSWERS, Group
from hfc_design.batch.page import group_row
from hfc_design.batch.sentences import broken, sentence
from hfc_design.batch.summary import Findings
from hfc_design.core.console import show_rows, terminal
from hfc_design.core.records import harmless

#: Of so many tasks, and groups of each, the medians are told.
TASKS, GROUPS = 6, 10
HEAD = ["group", "runs", "median", "quartiles", "best"]


def tell(page: Path, found: Findings | None) -> None:
    """Print what the runs gave, if it is more than one, and where the page is."""
    if found is not None:
        tasks = list(dict.fromkeys(group.task for group in found.groups))
        for task in tasks[:TASKS]:
            groups = [group for group in found.groups if group.task == task]
            _show(groups)
            terminal().print(Text(harmless(sentence(groups, found.comparisons))))
            if failed := broken(groups):
                terminal().print(Text(harmless(failed)))
            terminal().print()
        if len(tasks) > TASKS:
            terminal().print(f"{len(tasks) - TASKS} more tasks are in groups.csv\n")
        structures.tell(found.winners)
    print(page)


def _show(groups: list[Group]) -> None:
    """The medians of a task over the seeds, the highest first."""
    title = f"{groups[0].task}: {groups[0].measure}"
    heads = [*HEAD, *(ANSWERS if groups[0].answers else [])]
    cells = ([harmless(group.label), *group_row(group, [])[1:]] for group in groups[:GROUPS])
    show_rows(heads, (map(Text, row) for row in cells), title=Text(harmless(title)), title_style="")
    if len(groups) > GROUPS:
        terminal().print(f"{len(groups) - GROUPS} more groups are in groups.csv")
