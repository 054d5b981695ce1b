"""What came out of a batch in words, at a terminal, on its page and in captions."""

from collections.abc import Sequence

import numpy as np

from hfc_design.batch import comparisons as compared
from hfc_design.batch.comparisons import Comparison
from hfc_design.batch.groups import FITNESS, Group
from hfc_design.pictures.numbers import score

#: So many groups are named in a caption; of more the table of the groups says what they are.
NAMED = 12
#: What keys begin with that make a task harder or easier, whoever controls.
OF_MACHINE = ("plant.", "reference.", "load.", "limits.", "sensors.", "start.", "simulation.")


def sentence(groups: Sequence[Group], comparisons: Sequence[Comparison]) -> str:
    """What came out of a task, nothing of groups whose runs are too few to tell them apart.

    Args:
        groups: of the task, the best first.
        comparisons: of all tasks, which p is corrected for.
    """
    highest = max(groups, key=lambda group: np.nan_to_num(group.median, nan=-np.inf))
    if not highest.finished:
        return "No run has finished."
    told = ""
    if answers := groups[0].answers:
        told = f"{answers[0]} designs of group {groups[0].label} can be used; {answers[1]} % of "
        told += "the unseen machines pass in the median. "
    return told + _highest(highest, groups, comparisons)


def _highest(highest: Group, groups: Sequence[Group], comparisons: Sequence[Comparison]) -> str:
    against = [item for item in comparisons if item.first is highest]
    if against and (needed := compared.too_few(comparisons)):
        several = f"{len(comparisons)} comparisons need" if len(comparisons) > 1 else "it takes"
        return (
            "Which group is better cannot be shown with so few runs, however much they differ: "
            f"{several} at least {needed} runs in each group."
        )
    note = _unlike(groups)
    count = len(highest.finished)
    median = "fitness" if highest.measure == FITNESS else f"of {highest.measure}"
    told = f"The highest median {median} is {score(highest.median)}, of group {highest.label}"
    told += f" ({count} run{'s' if count > 1 else ''})"
    if not against:
        return f"{told}{_alone(groups)}.{note}"
    shown = sum(item.holm <= compared.ALPHA for item in against)
    if len(against) > 1:
        return f"{told}; by more than chance higher than {shown} of {len(against)} others.{note}"
    lower = "The other group is lower by more than chance"
    return f"{told}. {lower if shown else 'That the other group is lower may be chance'}.{note}"


def _unlike(groups: Sequence[Group]) -> str:
    """That groups of a task differ in more than controller and search, and in what they rank by."""
    keys = {key for group in groups for key in group.settings if key.startswith(OF_MACHINE)}
    each = {key: {group.settings.get(key) for group in groups} for key in keys}
    differ = ", ".join(sorted(key for key, values in each.items() if len(values) > 1))
    told = f" They differ in {differ} too: a higher score may be that of an easier task."
    merits = {run.judged_by for group in groups for run in group.finished if run.judged_by}
    other = f" Their searches ranked by different merits ({'; '.join(sorted(merits))})."
    return (told if differ else "") + (other if len(merits) > 1 else "")


def _alone(groups: Sequence[Group]) -> str:
    """That a single run of a search says nothing about another group."""
    searched = any(run.searched for group in groups for run in group.finished)
    chance = len(groups) > 1 and searched
    return ", which may be chance: a group needs several seeds" if chance else ""


def broken(groups: Sequence[Group]) -> str:
    """Which groups have runs that end with a design which breaks constraints; "" without any."""
    of_each = [
        f"{group.broken} of {len(group.finished)} runs of group {group.number}"
        for group in groups
        if group.broken
    ]
    if not of_each:
        return ""
    others = f" and runs of {len(of_each) - NAMED} more groups" if len(of_each) > NAMED else ""
    return (
        f"{', '.join(of_each[:NAMED])}{others} break constraints: no design that was tried there "
        "keeps every one, and the one that breaks them least counts."
    )


def key_of(groups: Sequence[Group]) -> str:
    """What the numbers of groups mean, for a caption that stands alone."""
    tasks = {group.task for group in groups}
    if len(groups) > NAMED:
        return "What the numbers of the groups mean is in the table of the groups."
    each = (f"{one.label} in {one.task}" if len(tasks) > 1 else one.label for one in groups)
    return f"Groups: {'; '.join(each)}."
