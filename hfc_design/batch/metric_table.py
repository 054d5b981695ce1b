"""The table of the metrics of a batch: a row each, a column for each group."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from hfc_design.batch.groups import MERIT, Group
from hfc_design.core.plugins import uses
from hfc_design.core.records import UserError, in_a_line
from hfc_design.pictures.numbers import digits, metric, score
from hfc_design.pictures.section import Rows
from hfc_design.report.comparison.tables import NONE, best, titled
from hfc_design.runs.run import DESIGN, opened_run, provenance
from hfc_design.simulation.comparison import SCORES
from hfc_design.simulation.evaluating import meanings

CAPTION = (
    "Median of each metric over the finished runs of a group, which differ in nothing but the "
    "seed, as far as they have it; the columns are the groups. The best of each task stands out."
)


class Metrics(NamedTuple):
    """What a page shows of the metrics."""

    head: list[str]
    rows: Rows
    best: list[list[int]]  # places of the best in each row
    meanings: list[tuple[str, str]]  # names, and meanings with their units
    caption: str = CAPTION


def metrics(path: Path, groups: Sequence[Group]) -> Metrics:
    """Medians of the metrics of groups of runs below ``path``."""
    found = [group.metrics() for group in groups]
    shown = {group.key for group in groups}  # of which the page has a table already
    keys = dict.fromkeys(key for item in found for key in item if {key} != shown)
    told = _meanings(path, groups, list(keys))
    rows, places = [], []
    for key in keys:
        values = [item[key][1] if key in item else None for item in found]
        name, factor = titled(key, told[key], values)
        write = score if key in SCORES else digits
        cells = [NONE if x is None else write(factor * x) for x in values]
        rows.append([name, *cells])
        places.append(_best(groups, key, values))
    known = [(metric(key, text)[0], text) for key, text in told.items() if "[" in text]
    return Metrics(["metric", *(str(group.number) for group in groups)], rows, places, known)


def _best(groups: Sequence[Group], key: str, values: Sequence[float | None]) -> list[int]:
    """Of each task with several groups; merits compare where all runs had the same one."""
    found = []
    for task in dict.fromkeys(group.task for group in groups):
        own = [k for k, group in enumerate(groups) if group.task == task]
        if key == MERIT and any(groups[k].key != MERIT for k in own):
            continue
        sizes = [values[k] for k in own]
        if key not in SCORES:
            sizes = [None if x is None else abs(x) for x in sizes]
        found += [own[k] + 1 for k in best(sizes, -1 if key in SCORES else 1) if len(own) > 1]
    return found


def _meanings(path: Path, groups: Sequence[Group], keys: Sequence[str]) -> dict[str, str]:
    """Of each metric what it is, with its unit, as far as a run still says; else its own name."""
    known: dict[str, str] = {}
    for group in {group.task: group for group in groups if group.finished}.values():
        if not known.keys() >= {*keys}:
            place = path / group.finished[0].path
            try:
                known |= meanings(opened_run(place))
            except (UserError, ValueError) as error:
                needed = uses(provenance(place / DESIGN).get("plugins"), known=False)
                told = f"give{needed}" if needed else in_a_line(str(error))
                head = f"hfc: warning: the metrics of {group.task} stand there without units"
                print(in_a_line(f"{head}: {told}"), file=sys.stderr)
    return {key: known.get(key, key if key in SCORES else "") for key in keys}
