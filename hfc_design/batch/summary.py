"""Summary of several runs in words and tables, for the terminal and for the page."""

from collections.abc import Iterable, Sequence
from itertools import groupby, islice

import numpy as np

from hfc_design.batch.findings import (
    FITNESS,
    Comparison,
    Findings,
    Group,
    Reproduced,
    Winner,
    too_few,
)
from hfc_design.core.tables import MISSING, Table, text
from hfc_design.plotting.numbers import score

STRUCTURES = "structures.csv"
#: Largest numbers of tasks, of groups of each, and of structures of a group that are printed.
TASKS, GROUPS, WINNERS = 6, 10, 3
#: Largest number of groups that a caption or a sentence names.
NAMED = 12
#: Prefixes of keys that make a task harder or easier for every controller.
OF_MACHINE = ("plant.", "reference.", "load.", "limits.", "sensors.", "start.", "simulation.")
OF_WINNERS = (
    "The structures that the searches of each group ended with, one search per seed, the most "
    "frequent first; shares with 95 % confidence (Clopper and Pearson)."
)
OF_FIGURES = (
    "Values printed in the paper and medians of the runs here. A dash: the paper gives no number, "
    "or no run has finished. In full precision: published.csv."
)


def group_table(groups: Sequence[Group], names: Sequence[Sequence[str]], *head: str) -> Table:
    """Return a row for each group: ``names`` (one list each, under ``head``), scores, answers."""
    answers = ["usable", "pass [%]"] if any(group.answers for group in groups) else []
    rows = []
    for name, group in zip(names, groups, strict=True):
        count, total = len(group.finished), len(group.runs)
        row = [*name, str(total) if count == total else f"{count} of {total}"]
        low, median, high = map(score, group.quartiles)
        numbers = (
            [median, f"{low} to {high}", score(group.scores.max())] if count else [MISSING] * 3
        )
        rows.append([*row, *numbers, *(answers and (group.answers or [MISSING] * len(answers)))])
    return Table("", [*head, "runs", "median", "quartiles", "best", *answers], rows)


def winner_table(winners: Iterable[Winner], key: str = "") -> Table:
    """Return a table of structures; ``key`` explains the numbers of the groups."""
    rows = []
    for x in winners:
        low, high = (100 * end for end in x.interval)
        which = [x.structure, str(x.group.number), f"{len(x.runs)} of {x.searches}"]
        share = f"{100 * x.share:.0f} ({low:.0f} to {high:.0f})"
        rows.append([*which, share, score(x.best), score(x.median)])
    head = ["structure", "group", "runs", "share [%]", "best", "median"]
    return Table(OF_WINNERS, head, rows, key=key)


def published_table(figures: Iterable[Reproduced]) -> Table:
    """Return a table of the published and simulated numbers."""
    rows = []
    for item in figures:
        ratio = MISSING if item.ratio is None else f"{item.ratio:.2f}"
        numbers = (_number(item.published), _number(item.simulated), ratio, str(item.runs))
        rows.append([item.figure, item.quantity, *numbers, item.remark])
    return Table(OF_FIGURES, Reproduced._fields, rows)


def _number(value: float | None) -> str:
    """Text of a number with three digits, or with all digits before the point."""
    if value is None:
        return MISSING
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e9 else f"{value:.3g}"


def tables(findings: Findings) -> list[Table]:
    """Return tables of the groups of each task, with sentences, and of the best structures."""
    shown = [_medians(findings, task) for task in findings.tasks[:TASKS]]
    if (more := len(findings.tasks) - TASKS) > 0:
        shown.append(text(f"{more} more tasks are in groups.csv"))
    by_group = groupby(findings.winners, key=lambda x: x.group.number)
    listed = [x for _, inside in islice(by_group, TASKS) for x in islice(inside, WINNERS)]
    if listed:
        more = len(findings.winners) - len(listed)
        lines = [f"{more} more structures are in {STRUCTURES}"] if more else []
        shown.append(winner_table(listed)._replace(title="best structures", lines=lines))
    return shown


def _medians(findings: Findings, task: str) -> Table:
    groups = findings.of_task(task)
    labels = [[group.label] for group in groups[:GROUPS]]
    more = len(groups) - GROUPS
    lines = [f"{more} more groups are in groups.csv"] if more > 0 else []
    lines += filter(None, [sentence(groups, findings.comparisons), broken(groups)])
    title = f"{task}: {groups[0].measure}"
    return group_table(groups[:GROUPS], labels, "group")._replace(title=title, lines=lines)


def sentence(groups: Sequence[Group], comparisons: Sequence[Comparison]) -> str:
    """Return the result of a task in words: usable designs, highest median, and differences.

    Args:
        groups: groups of the task, the best first.
        comparisons: comparisons of all tasks; p is corrected for their number.
    """
    highest = max(groups, key=lambda group: np.nan_to_num(group.median, nan=-np.inf))
    if not highest.finished:
        return "No run has finished."
    usable = ""
    if answers := groups[0].answers:
        usable = (
            f"Usable designs of group {groups[0].label}: {answers[0]}; median share of unseen "
            f"machines that pass: {answers[1]} %. "
        )
    against = [item for item in comparisons if item.first is highest]
    if against and (needed := too_few(comparisons)):
        several = f"{len(comparisons)} comparisons need" if len(comparisons) > 1 else "it takes"
        return (
            f"{usable}The runs are too few to show which group is better, whatever the "
            f"difference: {several} at least {needed} runs in each group."
        )
    runs, shown = len(highest.finished), sum(item.shown for item in against)
    median = "fitness" if highest.measure == FITNESS else f"of {highest.measure}"
    best = f"{usable}The highest median {median} is {score(highest.median)}, of group "
    best += f"{highest.label} ({runs} run{'s' if runs > 1 else ''})"
    if not against:
        searched = any(run.searched for group in groups for run in group.finished)
        chance = ", which may be chance: run each group with several seeds"
        best += chance if searched and len(groups) > 1 else ""
    elif len(against) > 1:
        best += f"; significantly higher than {shown} of {len(against)} other groups"
    elif shown:
        best += ". The other group is significantly lower"
    else:
        best += ". The difference to the other group may be chance"
    return f"{best}.{_unlike(groups)}"


def _unlike(groups: Sequence[Group]) -> str:
    """Return notes on differing machines or motions, and on different merits; "" if none differ."""
    keys = {key for group in groups for key in group.settings if key.startswith(OF_MACHINE)}
    values = {key: {group.settings.get(key) for group in groups} for key in keys}
    differ = ", ".join(sorted(key for key, some in values.items() if len(some) > 1))
    note = f" The groups also differ in {differ}: a higher score may come from an easier task."
    merits = {run.judged_by for group in groups for run in group.finished if run.judged_by}
    other = f" Their searches ranked designs by different merits ({'; '.join(sorted(merits))})."
    return (note if differ else "") + (other if len(merits) > 1 else "")


def broken(groups: Sequence[Group]) -> str:
    """Return a sentence on runs whose design violates constraints; "" if there are none."""
    with_broken = [group for group in groups if group.broken]
    if not with_broken:
        return ""
    counts = [f"{x.broken} of {len(x.finished)} runs of group {x.number}" for x in with_broken]
    others = f" and runs of {len(counts) - NAMED} more groups" if len(counts) > NAMED else ""
    return (
        f"{', '.join(counts[:NAMED])}{others} violate constraints: no design tried there "
        "meets all of them, so the one with the least violation counts."
    )


def key_of(groups: Sequence[Group]) -> str:
    """Return an explanation of the groups' numbers, so that a caption is self-contained."""
    if len(groups) > NAMED:
        return "The table of groups says what the group numbers mean."
    several = len({group.task for group in groups}) > 1
    labels = (f"{group.label} in {group.task}" if several else group.label for group in groups)
    return f"Groups: {'; '.join(labels)}."
