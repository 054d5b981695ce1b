"""How the searches of several folders converge, in one picture."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hfc_design.batch.groups import Group, grouped
from hfc_design.batch.runs import runs_below
from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError
from hfc_design.files.together import apart
from hfc_design.report import searches
from hfc_design.runs.run import opened_run

#: So many curves can be told apart.
MOST = 10


def convergence(folders: Sequence[Path]) -> Figure:
    """Best merit so far against generation: a curve of each run folder, or of the groups below one.

    That of a group is the median of its finished runs over a band between their quartiles.

    Raises:
        UserError: a folder has no run or no history, stands there twice, or there are too many
            curves.
    """
    for k, path in enumerate(folders):
        if any(path.resolve() == other.resolve() for other in folders[:k]):
            raise UserError(f"{path}: stands there twice; it does what it does")
    curves: dict[str, list[Floats]] = {}
    titles = set()
    parts = [path.resolve().parts for path in folders]
    names = apart([own[-1] for own in parts], parts)
    for path, name in zip(folders, names, strict=True):
        found = list(_curves(path))
        if not found:
            raise UserError(f"{path}: has no history of a search")
        for group, bests, title in found:
            task = f", {group.task}" if len({one.task for one, *_ in found}) > 1 else ""
            which = f"{group.label}{task}" if len(found) > 1 else ""
            called = name if len(folders) > 1 or not which else ""
            curves[f"{called} {which}".strip()] = bests
            titles.add(title)
    if len(curves) > MOST:
        raise UserError(f"{len(curves)} curves are more than the {MOST} that can be told apart")
    measure = titles.pop() if len(titles) == 1 else "merit, each by its own,"
    return searches.convergence(list(curves), list(curves.values()), range(len(curves)), measure)


def _curves(path: Path) -> Iterator[tuple[Group, list[Floats], str]]:
    """Of each group that has any its histories, and what they were ranked by."""
    for group in grouped(runs_below(path)):
        known = [run for run in group.finished or group.runs if np.isfinite(run.best).any()]
        if known:
            one = known[0]
            title = one.judged_by or opened_run(path / one.path).judge().title
            yield group, [run.best for run in known], title
