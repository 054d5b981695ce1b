"""Which structures the searches of a group ended with: how many of its seeds, and how good."""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.batch.groups import Group, quartiles
from hfc_design.batch.runs import Run
from hfc_design.core.numbers import Floats
from hfc_design.core.shown import line
from hfc_design.core.statistics import Interval, share_interval


class Winner(NamedTuple):
    """A structure that searches of a group ended with."""

    group: Group
    structure: str  # as the genome tells it
    runs: list[Run]  # that ended with it, the best first
    scores: Floats  # (runs,) what the group is compared by; -inf where a design diverged
    searches: int  # finished ones of the group, one a seed, whose structure is known

    def __repr__(self) -> str:
        told = {"group": self.group.label, "structure": self.structure, "best": self.best}
        return line("Winner", {**told, "runs": len(self.runs), "searches": self.searches})

    @property
    def share(self) -> float:
        """Of the searches."""
        return len(self.runs) / self.searches

    @property
    def interval(self) -> Interval:
        """Where the share of all seeds lies, of which these are a sample."""
        return share_interval(len(self.runs), self.searches)

    @property
    def best(self) -> float:
        """The highest of the scores."""
        return float(self.scores[0])

    @property
    def median(self) -> float:
        """Of the scores."""
        return quartiles(self.scores)[1]


def winners(groups: Sequence[Group]) -> list[Winner]:
    """The structures of each group, the most frequent first, of equally frequent ones the best.

    A design that was given is no search's; a group whose kind has but one structure has none.
    """
    found: list[Winner] = []
    for group in groups:
        members: dict[str, list[tuple[float, Run]]] = defaultdict(list)
        for run, value in zip(group.finished, group.scores.tolist(), strict=True):
            if run.searched and run.structure:
                members[run.structure].append((value, run))
        searches = sum(map(len, members.values()))
        own = [_winner(group, structure, inside, searches) for structure, inside in members.items()]
        found += sorted(own, key=lambda one: (-len(one.runs), -one.best, one.structure))
    return found


def _winner(group: Group, structure: str, inside: list[tuple[float, Run]], searches: int) -> Winner:
    scores, runs = zip(*sorted(inside, key=lambda pair: -pair[0]), strict=True)
    return Winner(group, structure, list(runs), np.array(scores), searches)
