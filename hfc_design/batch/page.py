"""The page of several runs: the results first, the single runs last."""

import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from matplotlib.figure import Figure

from hfc_design.batch.findings import (
    ALPHA,
    COMPARED,
    EXACT,
    FITNESS,
    MERIT,
    Comparison,
    Findings,
    Group,
    Reproduced,
    Winner,
    too_few,
)
from hfc_design.batch.folder import batch_notes
from hfc_design.batch.plan import OWN_KEYS
from hfc_design.batch.results import MARGINS, Run, batches_below, listed, text
from hfc_design.batch.summary import (
    broken,
    group_table,
    key_of,
    published_table,
    sentence,
    winner_table,
)
from hfc_design.core.plugins import uses
from hfc_design.core.records import UserError, in_a_line
from hfc_design.core.tables import MISSING, Table
from hfc_design.core.wording import alternatives
from hfc_design.files.design import Design
from hfc_design.files.labels import LABEL, SEED
from hfc_design.files.loop_setup import load_design
from hfc_design.files.scenario import Scenario
from hfc_design.plotting.figure import LARGEST
from hfc_design.plotting.numbers import digits, metric, score
from hfc_design.plotting.section import Drawing
from hfc_design.report import REPORT, Page, batch_plots, capital, rendered, searches
from hfc_design.report.comparison.tables import best, p_text, titled
from hfc_design.report.designs import picture
from hfc_design.report.parts import fitness_told
from hfc_design.runs.run import DESIGN, opened_run, provenance
from hfc_design.simulation.comparison import SCORES
from hfc_design.simulation.evaluating import meanings
from hfc_design.simulation.repeats import TOLD, range_text

#: Largest numbers of tasks, and of groups of each task, that are drawn: the first on the page.
TASKS, DRAWN = 6, 10
#: Largest numbers of rows of the tables on the page; the CSV files have all rows.
GROUPS, COMPARISONS, TROUBLES, RUNS = 200, 100, 200, 5000
#: Largest numbers of ratios of published figures, and of groups whose best structure is drawn.
RATIOS, TREES = 60, 6
#: A table of more runs than this is folded until a reader opens it.
UNFOLDED = 60
CAPTION = (
    "Median of each metric over the finished runs of a group that have it. The runs of a "
    "group differ only in their seed. The columns are the groups; the best of each task "
    "is highlighted."
)
OF_GROUPS = (
    "Median, quartiles and best of {} over runs that differ only in their seed; higher is better, "
    "and {} of each task is listed first."
)
OF_COMPARISONS = (
    "Groups of the same task, two by two, by {}: how often a run of the first is higher than one "
    "of the second (A₁₂), p of the two-sided Mann-Whitney U test, and p after Holm’s "
    "correction{}; a difference counts as shown up to {}."
)
TROUBLE = (
    "A run outside a batch that is still going on is listed as broken off. A run of which only the "
    "history is damaged counts, but its curve is not drawn."
)


def page(path: Path, findings: Findings) -> Page:
    """Return the page of the runs below ``path``; the same runs give the same bytes."""
    runs, groups, comparisons, figures, winners = findings
    differing = list(groups[0].settings) if groups else []
    labelled = LABEL in differing and all(LABEL in run.settings for run in runs)
    keys = [key for key in differing if key in OWN_KEYS] if labelled else differing
    counts = Counter(run.state for run in runs)
    troubles = [run for run in runs if run.reason or run.state != "finished"]
    searched = [group for group in groups if any(run.searched for run in group.runs)]
    known = next((run.settings for run in runs if run.settings), {})
    shown, trees = groups[:GROUPS], _trees(path, winners)
    metrics, meant, fitness = _metrics(path, shown)
    key = " ".join(filter(None, [key_of(shown), fitness]))
    measures = alternatives(dict.fromkeys(group.measure for group in groups))
    judged = any(run.verdict for run in runs)
    notes = (one for place in batches_below(path) for one in batch_notes(place))
    return rendered(
        "batch.html.j2",
        path.resolve().name,
        name=path.resolve().name,
        findings=findings,
        descriptions=[one.description for one in notes if one.description],
        counts=listed(counts),
        tasks=[_task(findings, task, k < TASKS) for k, task in enumerate(findings.tasks)],
        same=[(key, text(known[key])) for key in known if key not in (*differing, SEED)],
        labelled=labelled,
        published=published_table(figures),
        ratios=_ratios(figures),
        random=any(run.searched for run in runs),
        repeated=counts["finished"] - sum(len(group.finished) for group in groups),
        merits=any(group.measure != FITNESS for group in groups),
        chaotic=sum(bool(run.ranges) for run in runs),
        repeats=TOLD,
        few=sum(len(group.finished) < 5 for group in searched),  # given designs: not random
        group_table=_groups(shown, keys, judged, measures, fitness),
        metrics=metrics._replace(key=f" {key}"),
        meant=meant,
        fitness=fitness,
        winner_table=winner_table(winners[:GROUPS], f" {key}"),
        broken=broken([*{one.group.number: one.group for one in winners}.values()]),
        trees=trees,
        comparison_table=_comparisons(comparisons, measures, f" {key}"),
        too_few=too_few(comparisons),
        alpha=ALPHA,
        exact=EXACT,
        compared=COMPARED,
        trouble_table=Table(
            TROUBLE,
            ["run", "state", "reason"],
            [[run.title, run.state, run.reason] for run in troubles[:TROUBLES]],
        ),
        troubles=len(troubles),
        run_table=_runs(findings, keys, judged),
        unfolded=UNFOLDED,
    )


def _task(findings: Findings, task: str, draw: bool) -> dict[str, Any]:
    """Return the texts of a task on the page and, if ``draw``, its figures."""
    groups = findings.of_task(task)
    drawn = [group for group in groups if group.finished][: DRAWN if draw else 0]
    curves = {k: group for k, group in enumerate(drawn) if group.with_history}
    convergence = outcomes = None
    if curves:
        bests = {x.label: [run.best for run in x.with_history] for x in curves.values()}
        convergence = searches.convergence(bests, order=list(curves))
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


def _groups(
    groups: Sequence[Group], keys: Sequence[str], judged: bool, measures: str, fitness: str
) -> Table:
    """Table of the groups; each task's best median and best run are marked."""
    places: list[list[int]] = [[] for _ in groups]
    finished = [k for k, group in enumerate(groups) if group.finished]
    some = [groups[k] for k in finished]
    medians, bests = [x.median for x in some], [x.scores.max() for x in some]
    for place, values in ((len(keys) + 2, medians), (len(keys) + 4, bests)):
        for k in _best_of_tasks(some, values, -1):
            places[finished[k]].append(place)
    first = "the group that is usable most often" if judged else "the highest median"
    names = [[str(x.number), *(x.settings[key] for key in keys)] for x in groups]
    about = OF_GROUPS.format(measures, first)
    table, key = group_table(groups, names, "group", *keys), f" {fitness}" * bool(fitness)
    return table._replace(caption=about, best=places, key=key)


def _best_of_tasks(
    groups: Sequence[Group], values: Sequence[float | None], sign: int
) -> Iterator[int]:
    """Yield, for each task with several groups, the indices of the least ``sign`` times value."""
    for task in dict.fromkeys(group.task for group in groups):
        inside = [k for k, group in enumerate(groups) if group.task == task]
        if len(inside) > 1:
            yield from (inside[k] for k in best([values[k] for k in inside], sign))


def _comparisons(comparisons: Sequence[Comparison], measures: str, key: str) -> Table:
    """Table of the first comparisons."""
    rows = []
    for x in comparisons[:COMPARISONS]:
        verdict = f"{x.first.number} is higher" if x.shown else "not shown"
        names, sizes = f"{x.first.number} and {x.second.number}", ", ".join(map(str, x.sizes))
        numbers = (f"{x.a12:.2f}", p_text(x.p), p_text(x.holm))
        rows.append([names, sizes, *numbers, verdict if x.testable else "too few runs"])
    many = f" for all {len(comparisons)} comparisons" if len(comparisons) > 1 else ""
    head = ["groups", "runs", "A₁₂", "p", "p (Holm)", "difference"]
    return Table(OF_COMPARISONS.format(measures, many, ALPHA), head, rows, key=key)


def _runs(findings: Findings, keys: Sequence[str], judged: bool) -> Table:
    """Return a table of the first ``RUNS`` runs, with links to their own pages, if these exist."""
    runs, number = findings.runs, findings.number_of()
    scores = (FITNESS, MERIT) if any(MERIT in run.score for run in runs) else (FITNESS,)
    margins = [key for key in MARGINS if any(key in run.margins for run in runs)]
    rows, links = [], []
    for run in runs[:RUNS]:
        row = [run.title, str(number.get(run.path, "–")), *map(run.setting, (*keys, SEED))]
        row += [run.state, *(_score(run, key) for key in scores)]
        if judged:
            numbers = [run.share and 100 * run.share, *map(run.margins.get, margins)]
            row += [run.verdict or "–", *("–" if x is None else f"{x:.4g}" for x in numbers)]
        row.append(str(len(run.best)))
        rows.append(row)
        links.append(f"{quote(run.path)}/{REPORT}" if run.page else "")
    answers = ["answer", "share [%]", *margins] if judged else []
    head = ["run", "group", *keys, "seed", "state", *scores, *answers, "generations"]
    return Table("Settings, outcome and generations of each run.", head, rows, links=links)


def _score(run: Run, key: str) -> str:
    """Fitness or merit of a run, as a range if the loop is chaotic."""
    if key in run.ranges:
        return range_text(run.ranges[key])
    value = run.score.get(key, "–")  # None: the design diverged
    return value if isinstance(value, str) else score(-np.inf if value is None else value)


def _metrics(path: Path, groups: Sequence[Group]) -> tuple[Table, list[tuple[str, str]], str]:
    """Return a table of median metrics of groups, meanings of the metrics, and of the fitness."""
    medians = [group.metrics() for group in groups]
    shown = {group.key for group in groups}  # the page has another table of this
    keys = dict.fromkeys(key for item in medians for key in item if {key} != shown)
    scenarios = _scenarios(path, groups, list(keys))
    known = {key: text for one in scenarios.values() for key, text in meanings(one).items()}
    meaning = {key: known.get(key, key if key in SCORES else "") for key in keys}
    rows, places = [], []
    for key in keys:
        values = [item[key][1] if key in item else None for item in medians]
        name, factor = titled(key, meaning[key], values)
        write = score if key in SCORES else digits
        cells = [MISSING if x is None else write(factor * x) for x in values]
        rows.append([name, *cells])
        # Larger scores are better; merits are compared only if all runs have the same one.
        # Of other metrics the value nearest to 0 is the best.
        sizes = [
            None if x is None or key == MERIT != group.key else x if key in SCORES else abs(x)
            for x, group in zip(values, groups, strict=True)
        ]
        places.append([1 + k for k in _best_of_tasks(groups, sizes, -1 if key in SCORES else 1)])
    meant = [(metric(key, text)[0], text) for key, text in meaning.items() if "[" in text]
    head = ["metric", *(str(group.number) for group in groups)]
    return Table(CAPTION, head, rows, places), meant, _fitness(groups, scenarios)


def _scenarios(path: Path, groups: Sequence[Group], keys: Sequence[str]) -> dict[str, Scenario]:
    """Return task -> scenario, if a run can still be read; warn of ``keys`` without units."""
    scenarios: dict[str, Scenario] = {}
    for group in {group.task: group for group in groups if group.finished}.values():
        place = path / group.finished[0].path
        try:
            scenarios[group.task] = opened_run(place)
        except (UserError, ValueError) as error:
            if not {key for one in scenarios.values() for key in meanings(one)} >= {*keys}:
                needed = uses(provenance(place / DESIGN).get("plugins"), known=False)
                said = error.typed if isinstance(error, UserError) else str(error)
                why = f"give{needed}" if needed else said
                head = f"hfc: warning: the metrics of {group.task} are shown without units"
                print(in_a_line(f"{head}: {why}"), file=sys.stderr)
    return scenarios


def _fitness(groups: Sequence[Group], scenarios: Mapping[str, Scenario]) -> str:
    """Return the definition of the fitness that compares groups; "" if unknown or not the same."""
    tasks = {group.task for group in groups if group.finished and group.key == FITNESS}
    texts = {fitness_told(scenarios[task]) if task in scenarios else "" for task in tasks}
    return f"{texts.pop()}." if len(texts) == 1 and texts != {""} else ""


def _ratios(figures: Sequence[Reproduced]) -> Figure | None:
    """Return a picture of the first ``RATIOS`` positive ratios; None if there are none."""
    shown = [item for item in figures if 1 / LARGEST < (item.ratio or 0) < LARGEST][:RATIOS]
    names = ((f"{item.figure} {item.quantity}".strip(), item.remark) for item in shown)
    labels = [", ".join(filter(None, parts)) for parts in names]
    return batch_plots.ratios(labels, [item.ratio or 0 for item in shown]) if shown else None


def _trees(path: Path, winners: Sequence[Winner]) -> list[Drawing]:
    """Draw the most frequent structure of each of the first groups below ``path``.

    The drawing shows the structure's best run. Kinds of controller without such a picture are
    skipped; so are designs that cannot be read, with a warning.
    """
    first = {x.group.number: x for x in reversed(winners)}
    drawings = []
    for _, winner in sorted(first.items())[:TREES]:
        place = winner.runs[0].path
        try:
            design = load_design(str(path / place))
        except UserError as error:
            warning = f"hfc: warning: the structure of {place} is not drawn"
            print(in_a_line(f"{warning}: {error.lines[0]}"), file=sys.stderr)
            continue
        with suppress(UserError):
            drawings += list(_trees_of(winner, design))
    return drawings


def _trees_of(winner: Winner, design: Design) -> Iterator[Drawing]:
    """Yield the trees of the winner's best design; axes with the same tree are drawn once."""
    runs, searches = winner.runs, winner.searches
    parts: dict[Any, list[str]] = {}
    for axis, part in design.by_axis().items():
        parts.setdefault(part.kind.structure(part.controller), []).append(axis)
    for axes in (axes for structure, axes in parts.items() if structure):
        axis = axes[0]
        names = f", {'axes' if len(axes) > 1 else 'axis'} {' and '.join(axes)}"
        which = f"group {winner.group.label}" + names * bool(axis)
        count = f"{len(runs)} of {searches} searches ended with this structure, the best of them"
        if len(runs) == 1 < searches:
            count = "no two searches ended with the same structure; this is the best one's,"
        text = f"{capital(which)}: {count} {runs[0].path}; the scales are those of that run."
        yield Drawing(picture(design, "tree", axis=axis), f"Best structure of {which}", text)
