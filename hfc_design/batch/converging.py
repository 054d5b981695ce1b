"""How the searches of several folders converge, in one picture."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hfc_design.batch.groups import Group, grouped
from hfc_design.batch.runs import runs_below
from hfc_design.batch.summary import Findings
from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError
from hfc_design.files.cells import called
from hfc_design.files.together import apart
from hfc_design.report import searches
from hfc_design.runs.run import opened_run

#: So many curves can be told apart.
MOST = 10
#: A group, (generations,) of each of its runs, and what they were ranked by.
Curves = tuple[Group, list[Floats], str]


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
    parts = [path.resolve().parts for path in folders]
    own = zip(folders, parts, strict=True)
    names = apart([called(path) or part[-1] for path, part in own], parts)
    each = {}
    for path, name in zip(folders, names, strict=True):
        each[name] = list(_curves(path))
        if not each[name]:
            raise UserError(f"{path}: has no history of a search")
    return _drawn(each)


def of_findings(found: Mapping[str, Findings]) -> Figure:
    """The same of what runs gave, by the names that they are to have.

    Raises:
        UserError: nothing was searched, or there are too many curves.
    """
    each = {name: [*_known(one.groups)] for name, one in found.items()}
    for name, groups in each.items():
        if not groups:
            raise UserError(f"{name or 'findings'}: no run has a history of a search")
    return _drawn(each)


def _drawn(each: Mapping[str, list[Curves]]) -> Figure:
    curves: dict[str, list[Floats]] = {}
    titles = set()
    for name, found in each.items():
        for group, bests, title in found:
            task = f", {group.task}" if len({one.task for one, *_ in found}) > 1 else ""
            which = f"{group.label}{task}" if len(found) > 1 else ""
            called = name if len(each) > 1 or not which else ""
            curves[f"{called} {which}".strip() or group.label] = bests
            titles.add(title)
    if len(curves) > MOST:
        raise UserError(f"{len(curves)} curves are more than the {MOST} that can be told apart")
    measure = titles.pop() if len(titles) == 1 else "merit, each by its own,"
    return searches.convergence(list(curves), list(curves.values()), range(len(curves)), measure)


def _known(groups: Sequence[Group]) -> Iterator[Curves]:
    """Of each group that has any its histories, and what they were ranked by."""
    for group in groups:
        runs = [run for run in group.finished or group.runs if np.isfinite(run.best).any()]
        if runs:
            yield group, [run.best for run in runs], runs[0].judged_by or group.measure


def _curves(path: Path) -> Iterator[Curves]:
    """The same of the groups below a folder; a run that goes on says itself what ranks it."""
    for group, bests, title in _known(grouped(runs_below(path))):
        one = next(run for run in group.finished or group.runs if np.isfinite(run.best).any())
        yield group, bests, (one.judged_by and title) or opened_run(path / one.path).judge().title
