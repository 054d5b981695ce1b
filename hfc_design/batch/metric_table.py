"""The table of the metrics of a batch: a row each, a column for each group."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hfc_design.batch.groups import FITNESS, MERIT, Group
from hfc_design.core.plugins import uses
from hfc_design.core.records import UserError, in_a_line
from hfc_design.files.scenario import Scenario
from hfc_design.pictures.numbers import digits, metric, score
from hfc_design.pictures.section import Rows
from hfc_design.report.comparison.tables import NONE, best, titled
from hfc_design.report.verdict import fitness_told
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
    fitness: str  # what it is, a sentence; "" if nothing is to be said
    caption: str = CAPTION


def metrics(path: Path, groups: Sequence[Group]) -> Metrics:
    """Medians of the metrics of groups of runs below ``path``."""
    found = [group.metrics() for group in groups]
    shown = {group.key for group in groups}  # of which the page has a table already
    keys = dict.fromkeys(key for item in found for key in item if {key} != shown)
    scenarios = _scenarios(path, groups, list(keys))
    known = {key: text for one in scenarios.values() for key, text in meanings(one).items()}
    told = {key: known.get(key, key if key in SCORES else "") for key in keys}
    rows, places = [], []
    for key in keys:
        values = [item[key][1] if key in item else None for item in found]
        name, factor = titled(key, told[key], values)
        write = score if key in SCORES else digits
        cells = [NONE if x is None else write(factor * x) for x in values]
        rows.append([name, *cells])
        places.append(_best(groups, key, values))
    meant = [(metric(key, text)[0], text) for key, text in told.items() if "[" in text]
    head = ["metric", *(str(group.number) for group in groups)]
    return Metrics(head, rows, places, meant, _fitness(groups, scenarios))


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


def _scenarios(path: Path, groups: Sequence[Group], keys: Sequence[str]) -> dict[str, Scenario]:
    """By the tasks, as far as a run still says; where ``keys`` stay without units it is told."""
    found: dict[str, Scenario] = {}
    for group in {group.task: group for group in groups if group.finished}.values():
        place = path / group.finished[0].path
        try:
            found[group.task] = opened_run(place)
        except (UserError, ValueError) as error:
            if not {key for one in found.values() for key in meanings(one)} >= {*keys}:
                needed = uses(provenance(place / DESIGN).get("plugins"), known=False)
                told = f"give{needed}" if needed else in_a_line(str(error))
                head = f"hfc: warning: the metrics of {group.task} stand there without units"
                print(in_a_line(f"{head}: {told}"), file=sys.stderr)
    return found


def _fitness(groups: Sequence[Group], scenarios: Mapping[str, Scenario]) -> str:
    """What the fitness is that groups are compared by; "" if not the same for all, or unknown."""
    tasks = {group.task for group in groups if group.finished and group.key == FITNESS}
    told = {fitness_told(scenarios[task]) if task in scenarios else "" for task in tasks}
    return f"{told.pop()}." if len(told) == 1 and told != {""} else ""
