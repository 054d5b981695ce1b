"""What came out of a batch in words, at a terminal, on its page and in captions."""

from collections.abc import Sequence

from hfc_design.batch import comparisons as compared
from hfc_design.batch.comparisons import Comparison
from hfc_design.batch.groups import FITNESS, Group
from hfc_design.pictures.numbers import score

#: So many groups are named in a caption; of more the table of the groups says what they are.
NAMED = 12


def sentence(groups: Sequence[Group], comparisons: Sequence[Comparison]) -> str:
    """What came out of a task, nothing of groups whose runs are too few to tell them apart.

    Args:
        groups: of the task, the highest median first.
        comparisons: of all tasks, which p is corrected for.
    """
    highest = groups[0]
    if not highest.finished:
        return "No run has finished."
    against = [item for item in comparisons if item.first is highest]
    if against and (needed := compared.too_few(comparisons)):
        several = f"{len(comparisons)} comparisons need" if len(comparisons) > 1 else "it takes"
        return (
            "Which group is better cannot be shown with so few runs, however much they differ: "
            f"{several} at least {needed} runs in each group."
        )
    count = len(highest.finished)
    median = "fitness" if highest.measure == FITNESS else f"of {highest.measure}"
    told = f"The highest median {median} is {score(highest.median)}, of group {highest.label}"
    told += f" ({count} run{'s' if count > 1 else ''})"
    if not against:
        return f"{told}{_alone(groups)}."
    shown = sum(item.holm <= compared.ALPHA for item in against)
    if len(against) > 1:
        return f"{told}; by more than chance higher than {shown} of {len(against)} others."
    lower = "The other group is lower by more than chance"
    return f"{told}. {lower if shown else 'That the other group is lower may be chance'}."


def _alone(groups: Sequence[Group]) -> str:
    """That a single run of a search says nothing about another group."""
    searched = any(run.searched for group in groups for run in group.finished)
    chance = len(groups) > 1 and searched
    return ", which may be chance: a group needs several seeds" if chance else ""


def key_of(groups: Sequence[Group]) -> str:
    """What the numbers of groups mean, for a caption that stands alone."""
    tasks = {group.task for group in groups}
    if len(groups) > NAMED:
        return "What the numbers of the groups mean is in the table of the groups."
    each = (f"{one.label} in {one.task}" if len(tasks) > 1 else one.label for one in groups)
    return f"Groups: {'; '.join(each)}."
