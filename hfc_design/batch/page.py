"""The page of many runs: what came out first, every single run last."""

import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import numpy as np

from hfc_design.batch import comparisons as compared
from hfc_design.batch.comparisons import Comparison, broken, key_of, sentence
from hfc_design.batch.groups import ANSWERS, FITNESS, MERIT, WINNER_HEAD, Group
from hfc_design.batch.plan import OWN_KEYS
from hfc_design.batch.runs import MARGINS, Run, listed, text
from hfc_design.batch.summary import Findings, Reproduced, figure_row, ratios
from hfc_design.core.plugins import uses
from hfc_design.core.records import UserError, in_a_line
from hfc_design.files.cells import LABEL, SEED
from hfc_design.files.scenario import Scenario
from hfc_design.pictures.numbers import digits, metric, score
from hfc_design.pictures.section import Drawing, Rows
from hfc_design.report import REPORT, Page, batch_plots, rendered, searches
from hfc_design.report.comparison.tables import NONE, best, p_text, titled
from hfc_design.report.parts import fitness_told
from hfc_design.runs.run import DESIGN, opened_run, provenance
from hfc_design.simulation.comparison import SCORES
from hfc_design.simulation.evaluating import meanings
from hfc_design.simulation.repeats import TOLD, range_told

#: So many tasks, and groups of each, are drawn: those with the highest medians.
TASKS, DRAWN = 6, 10
#: So many rows of each table stand on the page; the CSV files have all of them.
GROUPS, COMPARISONS, TROUBLES, RUNS = 200, 100, 200, 5000
#: Up to this many runs are shown at once, more only when asked for.
UNFOLDED = 60
CAPTION = (
    "Median of each metric over the finished runs of a group, which differ in nothing but the "
    "seed, as far as they have it; the columns are the groups. The best of each task stands out."
)


def page(
    path: Path, descriptions: Iterable[str], found: Findings, trees: Sequence[Drawing]
) -> Page:
    """``report.html`` of the folder ``path``; the same runs give the same bytes."""
    runs, groups, comparisons, figures, winners = found
    tasks = [
        _task([group for group in groups if group.task == task], comparisons, k < TASKS)
        for k, task in enumerate(dict.fromkeys(group.task for group in groups))
    ]
    differing = list(groups[0].settings) if groups else []
    labelled = LABEL in differing and all(LABEL in run.settings for run in runs)
    keys = [key for key in differing if key in OWN_KEYS] if labelled else differing
    counts = Counter(run.state for run in runs)
    troubles = [run for run in runs if run.reason or run.state != "finished"]
    searched = [group for group in groups if any(run.searched for run in group.runs)]
    measured = metrics(path, groups[:GROUPS])
    known = next((run.settings for run in runs if run.settings), {})
    scores = (FITNESS, MERIT) if any(MERIT in run.score for run in runs) else (FITNESS,)
    judged = any(run.use.verdict for run in runs)
    margins = [key for key in MARGINS if any(key in run.use.margins for run in runs)]
    asked = ["answer", "share [%]", *margins] if judged else []
    return rendered(
        "batch.html.j2",
        path.resolve().name,
        name=path.resolve().name,
        descriptions=descriptions,
        counts=listed(counts),
        tasks=tasks,
        same=[(key, text(known[key])) for key in known if key not in (*differing, SEED)],
        labelled=labelled,
        published=[figure_row(item) for item in figures],
        published_head=Reproduced._fields,
        ratios=ratios(figures),
        random=any(run.searched for run in runs),
        repeated=counts["finished"] - sum(len(group.finished) for group in groups),
        merits=any(group.measure != FITNESS for group in groups),
        chaotic=sum(bool(run.ranges) for run in runs),
        repeats=TOLD,
        few=sum(len(group.finished) < 5 for group in searched),  # what is given is not random
        **_group_table(groups, keys),
        metrics=measured,
        meant=measured.meanings,
        measures=" or ".join(dict.fromkeys(group.measure for group in groups)),
        key=" ".join(filter(None, [key_of(groups[:GROUPS]), measured.fitness])),
        winner_head=WINNER_HEAD,
        winner_rows=[one.row for one in winners[:GROUPS]],
        winners=len(winners),
        broken=broken([*{one.group.number: one.group for one in winners}.values()]),
        trees=trees,
        **_comparison_table(comparisons),
        left_out=any(task["groups"] > compared.COMPARED for task in tasks),
        trouble_rows=[[run.title, run.state, run.reason] for run in troubles[:TROUBLES]],
        troubles=len(troubles),
        run_head=["run", "group", *keys, "seed", "state", *scores, *asked, "generations"],
        run_rows=_run_rows(found, keys, scores, margins if judged else None),
        judged=judged,
        runs=len(runs),
        unfolded=len(runs) <= UNFOLDED,
    )


def _group_table(groups: Sequence[Group], keys: Sequence[str]) -> dict[str, Any]:
    """What the page shows of all groups."""
    shown = groups[:GROUPS]
    answers = ANSWERS if any(group.answers for group in shown) else []
    return {
        "group_head": ["group", *keys, "runs", "median", "quartiles", "best", *answers],
        "group_rows": [group.row(keys) for group in shown],
        "group_best": _best(shown, len(keys)),
        "groups": len(groups),
    }


def _comparison_table(comparisons: Sequence[Comparison]) -> dict[str, Any]:
    """What it shows of every two groups, no row where nothing can be shown."""
    too_few = compared.too_few(comparisons)
    return {
        "comparison_rows": [_comparison_row(x) for x in comparisons[:COMPARISONS] if not too_few],
        "comparisons": len(comparisons),
        "too_few": too_few,
        "alpha": compared.ALPHA,
        "exact": compared.EXACT,
        "compared": compared.COMPARED,
    }


def _task(groups: list[Group], comparisons: Sequence[Comparison], draw: bool) -> dict[str, Any]:
    """What the page says and draws of groups that can be compared."""
    drawn = [group for group in groups if group.finished][: DRAWN if draw else 0]
    curves = {}
    for k, group in enumerate(drawn):
        if bests := [run.best for run in group.finished if np.isfinite(run.best).any()]:
            curves[k] = bests
    convergence = outcomes = None
    if curves:
        labels = [drawn[k].label for k in curves]
        convergence = searches.convergence(labels, list(curves.values()), list(curves))
    if any(np.isfinite(group.scores).any() for group in drawn):
        scores = {group.label: group.scores for group in drawn}
        outcomes = batch_plots.outcomes(scores, groups[0].key)
    return {
        "name": groups[0].task,
        "sentence": f"{sentence(groups, comparisons)} {broken(groups)}".rstrip(),
        "measure": groups[0].measure,
        "groups": len(groups),
        "drawn": len(drawn),
        "convergence": convergence,
        "outcomes": outcomes,
    }


def _best(groups: Sequence[Group], keys: int) -> list[list[int]]:
    """Places of the highest median and of the best run of each task that has several groups."""
    values = [(group.median, group.scores.max(initial=-np.inf)) for group in groups]
    places: list[list[int]] = [[] for _ in groups]
    for task in dict.fromkeys(group.task for group in groups):
        own = [k for k, group in enumerate(groups) if group.task == task and group.finished]
        for n, place in ((0, keys + 2), (1, keys + 4)):
            for k in best([values[k][n] for k in own], -1):
                if len(own) > 1:
                    places[own[k]].append(place)
    return places


def _comparison_row(item: Comparison) -> list[str]:
    if not item.testable:
        verdict = "too few runs"
    else:
        verdict = f"{item.first.number} is higher" if item.holm <= compared.ALPHA else "not shown"
    pair = f"{item.first.number} and {item.second.number}"
    counts = f"{len(item.first.scores)}, {len(item.second.scores)}"
    return [pair, counts, f"{item.a12:.2f}", p_text(item.p), p_text(item.holm), verdict]


def _run_rows(
    found: Findings, keys: Sequence[str], scores: Sequence[str], margins: Sequence[str] | None
) -> list[tuple[str, list[str]]]:
    """Of each run the address of its own page, if it has one, and what the table says."""
    number = found.number_of()
    rows = []
    for run in found.runs[:RUNS]:
        own = (run.setting(key) for key in (*keys, SEED))
        row = [run.title, str(number.get(run.path, "–")), *own, run.state]
        row += [_score(run, key) for key in scores]
        row += [*(run.use.told(margins) if margins is not None else []), str(len(run.best))]
        rows.append((f"{quote(run.path)}/{REPORT}" if run.page else "", row))
    return rows


def _score(run: Run, key: str) -> str:
    """Fitness or merit of a run, a range where it is chaotic."""
    if key in run.ranges:
        return range_told(run.ranges[key])
    value = run.score.get(key, "–")  # None: the design diverged
    return value if isinstance(value, str) else score(-np.inf if value is None else value)


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
        places.append(_best_metric(groups, key, values))
    meant = [(metric(key, text)[0], text) for key, text in told.items() if "[" in text]
    head = ["metric", *(str(group.number) for group in groups)]
    return Metrics(head, rows, places, meant, _fitness(groups, scenarios))


def _best_metric(groups: Sequence[Group], key: str, values: Sequence[float | None]) -> list[int]:
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
