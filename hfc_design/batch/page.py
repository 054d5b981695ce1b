"""The page of several runs: the results first, the single runs last."""

import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import numpy as np

from hfc_design.batch.comparisons import ALPHA, COMPARED, EXACT, Comparison, too_few
from hfc_design.batch.findings import Findings
from hfc_design.batch.groups import ANSWERS, FITNESS, MERIT, Group
from hfc_design.batch.plan import OWN_KEYS
from hfc_design.batch.reproduction import Reproduced, figure_row, ratios
from hfc_design.batch.results import MARGINS, Run, listed, text
from hfc_design.batch.structures import WINNER_HEAD
from hfc_design.batch.summary_text import HEAD, broken, key_of, sentence
from hfc_design.core.plugins import uses
from hfc_design.core.records import UserError, in_a_line
from hfc_design.core.wording import alternatives
from hfc_design.files.labels import LABEL, SEED
from hfc_design.files.scenario import Scenario
from hfc_design.plotting.numbers import digits, metric, score
from hfc_design.plotting.section import Drawing, Rows
from hfc_design.report import REPORT, Page, batch_plots, rendered, searches
from hfc_design.report.comparison.tables import NONE, best, p_text, titled
from hfc_design.report.parts import fitness_told
from hfc_design.runs.run import DESIGN, opened_run, provenance
from hfc_design.simulation.comparison import SCORES
from hfc_design.simulation.evaluating import meanings
from hfc_design.simulation.repeats import TOLD, range_text

#: Largest numbers of tasks, and of groups of each, that are drawn: those with the highest medians.
TASKS, DRAWN = 6, 10
#: Largest numbers of rows of the tables on the page; the CSV files have all rows.
GROUPS, COMPARISONS, TROUBLES, RUNS = 200, 100, 200, 5000
#: Up to this many runs are shown unfolded; more are folded.
UNFOLDED = 60
CAPTION = (
    "Median of each metric over the finished runs of a group that have it. The runs of a "
    "group differ only in their seed. The columns are the groups; the best of each task "
    "is highlighted."
)


def page(
    path: Path, descriptions: Iterable[str], findings: Findings, trees: Sequence[Drawing]
) -> Page:
    """``report.html`` of the folder ``path``; the same runs give the same bytes."""
    runs, groups, comparisons, figures, winners = findings
    differing = list(groups[0].settings) if groups else []
    labelled = LABEL in differing and all(LABEL in run.settings for run in runs)
    keys = [key for key in differing if key in OWN_KEYS] if labelled else differing
    counts = Counter(run.state for run in runs)
    troubles = [run for run in runs if run.reason or run.state != "finished"]
    searched = [group for group in groups if any(run.searched for run in group.runs)]
    known = next((run.settings for run in runs if run.settings), {})
    shown = groups[:GROUPS]
    measured = metrics(path, shown)
    needed = too_few(comparisons)
    judged = any(run.use.verdict for run in runs)
    return rendered(
        "batch.html.j2",
        path.resolve().name,
        name=path.resolve().name,
        descriptions=descriptions,
        counts=listed(counts),
        tasks=[_task(findings, task, k < TASKS) for k, task in enumerate(findings.tasks)],
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
        group_head=["group", *keys, *HEAD[1:], *(ANSWERS if any(x.answers for x in shown) else [])],
        group_rows=[group.row(keys) for group in shown],
        group_best=_best_groups(shown, len(keys)),
        groups=len(groups),
        metrics=measured,
        meant=measured.meanings,
        measures=alternatives(dict.fromkeys(group.measure for group in groups)),
        key=" ".join(filter(None, [key_of(shown), measured.fitness])),
        winner_head=WINNER_HEAD,
        winner_rows=[one.row for one in winners[:GROUPS]],
        winners=len(winners),
        broken=broken([*{one.group.number: one.group for one in winners}.values()]),
        trees=trees,
        comparison_rows=[_comparison_row(x) for x in comparisons[:COMPARISONS] if not needed],
        comparisons=len(comparisons),
        too_few=needed,
        alpha=ALPHA,
        exact=EXACT,
        compared=COMPARED,
        left_out=any(len(findings.of_task(task)) > COMPARED for task in findings.tasks),
        trouble_rows=[[run.title, run.state, run.reason] for run in troubles[:TROUBLES]],
        troubles=len(troubles),
        **_run_table(findings, keys, judged),
        judged=judged,
        runs=len(runs),
        unfolded=len(runs) <= UNFOLDED,
    )


def _task(findings: Findings, task: str, draw: bool) -> dict[str, Any]:
    """Texts and figures on the page for a task, whose groups are comparable."""
    groups = findings.of_task(task)
    drawn = [group for group in groups if group.finished][: DRAWN if draw else 0]
    bests = ([run.best for run in group.with_history] for group in drawn)
    curves = {k: x for k, x in enumerate(bests) if x}
    convergence = outcomes = None
    if curves:
        labels = [drawn[k].label for k in curves]
        convergence = searches.convergence(labels, list(curves.values()), list(curves))
    if any(np.isfinite(group.scores).any() for group in drawn):
        scores = {group.label: group.scores for group in drawn}
        outcomes = batch_plots.outcomes(scores, groups[0].key)
    return {
        "name": task,
        "sentence": f"{sentence(groups, findings.comparisons)} {broken(groups)}".rstrip(),
        "measure": groups[0].measure,
        "groups": len(groups),
        "drawn": len(drawn),
        "convergence": convergence,
        "outcomes": outcomes,
    }


def _best_groups(groups: Sequence[Group], keys: int) -> list[list[int]]:
    """Columns of each group's median and best run that are the best of a task."""
    places: list[list[int]] = [[] for _ in groups]
    finished = [(k, group) for k, group in enumerate(groups) if group.finished]
    for place, value in ((keys + 2, lambda x: x.median), (keys + 4, lambda x: x.scores.max())):
        for k in _best_of_tasks([x for _, x in finished], [value(x) for _, x in finished], -1):
            places[finished[k][0]].append(place)
    return places


def _best_of_tasks(
    groups: Sequence[Group], values: Sequence[float | None], sign: int
) -> Iterator[int]:
    """Places of the least ``sign`` times a value of each task that has several groups."""
    for task in dict.fromkeys(group.task for group in groups):
        inside = [k for k, group in enumerate(groups) if group.task == task]
        if len(inside) > 1:
            yield from (inside[k] for k in best([values[k] for k in inside], sign))


def _comparison_row(item: Comparison) -> list[str]:
    verdict = f"{item.first.number} is higher" if item.shown else "not shown"
    return [
        f"{item.first.number} and {item.second.number}",
        ", ".join(map(str, item.sizes)),
        f"{item.a12:.2f}",
        p_text(item.p),
        p_text(item.holm),
        verdict if item.testable else "too few runs",
    ]


def _run_table(findings: Findings, keys: Sequence[str], judged: bool) -> dict[str, Any]:
    """Table of every run on the page, with the address of the run's own page, if it exists."""
    runs, number = findings.runs, findings.number_of()
    scores = (FITNESS, MERIT) if any(MERIT in run.score for run in runs) else (FITNESS,)
    margins = [key for key in MARGINS if any(key in run.use.margins for run in runs)]
    rows = []
    for run in runs[:RUNS]:
        row = [run.title, str(number.get(run.path, "–")), *map(run.setting, (*keys, SEED))]
        row += [run.state, *(_score(run, key) for key in scores)]
        row += [*(run.use.row(margins) if judged else []), str(len(run.best))]
        rows.append((f"{quote(run.path)}/{REPORT}" if run.page else "", row))
    answers = ["answer", "share [%]", *margins] if judged else []
    head = ["run", "group", *keys, "seed", "state", *scores, *answers, "generations"]
    return {"run_head": head, "run_rows": rows}


def _score(run: Run, key: str) -> str:
    """Fitness or merit of a run, as a range if the loop is chaotic."""
    if key in run.ranges:
        return range_text(run.ranges[key])
    value = run.score.get(key, "–")  # None: the design diverged
    return value if isinstance(value, str) else score(-np.inf if value is None else value)


class Metrics(NamedTuple):
    """Table of the metrics on a page."""

    head: list[str]
    rows: Rows
    best: list[list[int]]  # places of the best in each row
    meanings: list[tuple[str, str]]  # names, and meanings with their units
    fitness: str  # what it is, a sentence; "" if nothing is to be said
    caption: str = CAPTION


def metrics(path: Path, groups: Sequence[Group]) -> Metrics:
    """Medians of the metrics of groups of runs below ``path``."""
    medians = [group.metrics() for group in groups]
    shown = {group.key for group in groups}  # of which the page has a table already
    keys = dict.fromkeys(key for item in medians for key in item if {key} != shown)
    scenarios = _scenarios(path, groups, list(keys))
    known = {key: text for one in scenarios.values() for key, text in meanings(one).items()}
    meaning = {key: known.get(key, key if key in SCORES else "") for key in keys}
    rows, places = [], []
    for key in keys:
        values = [item[key][1] if key in item else None for item in medians]
        name, factor = titled(key, meaning[key], values)
        write = score if key in SCORES else digits
        cells = [NONE if x is None else write(factor * x) for x in values]
        rows.append([name, *cells])
        # Scores are the better the larger, merits where all runs had the same; of others what is
        # nearest to 0.
        sizes = [
            None if x is None or key == MERIT != group.key else x if key in SCORES else abs(x)
            for x, group in zip(values, groups, strict=True)
        ]
        places.append([1 + k for k in _best_of_tasks(groups, sizes, -1 if key in SCORES else 1)])
    meant = [(metric(key, text)[0], text) for key, text in meaning.items() if "[" in text]
    head = ["metric", *(str(group.number) for group in groups)]
    return Metrics(head, rows, places, meant, _fitness(groups, scenarios))


def _scenarios(path: Path, groups: Sequence[Group], keys: Sequence[str]) -> dict[str, Scenario]:
    """Scenarios of the tasks that a run still has; warns if ``keys`` remain without units."""
    scenarios: dict[str, Scenario] = {}
    for group in {group.task: group for group in groups if group.finished}.values():
        place = path / group.finished[0].path
        try:
            scenarios[group.task] = opened_run(place)
        except (UserError, ValueError) as error:
            if not {key for one in scenarios.values() for key in meanings(one)} >= {*keys}:
                needed = uses(provenance(place / DESIGN).get("plugins"), known=False)
                why = f"give{needed}" if needed else in_a_line(str(error))
                head = f"hfc: warning: the metrics of {group.task} are shown without units"
                print(in_a_line(f"{head}: {why}"), file=sys.stderr)
    return scenarios


def _fitness(groups: Sequence[Group], scenarios: Mapping[str, Scenario]) -> str:
    """Description of the fitness that compares the groups; "" if it differs or is unknown."""
    tasks = {group.task for group in groups if group.finished and group.key == FITNESS}
    texts = {fitness_told(scenarios[task]) if task in scenarios else "" for task in tasks}
    return f"{texts.pop()}." if len(texts) == 1 and texts != {""} else ""
