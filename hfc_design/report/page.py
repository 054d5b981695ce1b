"""The report of a run: one page that needs nothing else, and the rule tables as CSV."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hfc_design.controllers.flc import section as fuzzy
from hfc_design.controllers.flc.record import FuzzyRecord
from hfc_design.controllers.gains import section as gains
from hfc_design.controllers.hierarchical import section as hierarchical
from hfc_design.core.checkpoint import write_whole
from hfc_design.files.controller import HierarchicalSettings
from hfc_design.files.design import Design, HierarchicalDesign
from hfc_design.files.scenario import Scenario
from hfc_design.formats import csv_tables
from hfc_design.objectives.judge import Judge
from hfc_design.pictures.section import Rows, Section, score
from hfc_design.report import contour_plots, plots
from hfc_design.report.template import rendered
from hfc_design.runs.run import CONFIG, Result
from hfc_design.search.loop import Search
from hfc_design.simulation.evaluation import Evaluation, meanings

REPORT, TABLES = "report.html", "tables"
OWN = "this design"
#: What the summary compares with: name of the built-in design -> what a reader calls it.
PUBLISHED = {
    "lin-lee-1999-table-1": "Table I of Lin & Lee (1999)",
    "lin-lee-1999-table-2": "Table II",
    "jee-koren-2004-aflc": "the AFLC of Jee & Koren (2004)",
    "jee-koren-2004-flc": "their FLC",
    "jee-koren-2004-pid": "their PID",
}


def write_report(
    scenario: Scenario, result: Result, rivals: Mapping[str, Evaluation], folder: Path
) -> None:
    """Write ``report.html`` and ``tables/`` into the run folder.

    ``rivals`` are other designs on the same scenario. The page has everything inside it, and the
    same run gives the same bytes.

    Raises:
        RunError: the folder cannot be written.
    """
    design, own, search = result
    tables = isinstance(design.controller, (HierarchicalDesign, FuzzyRecord))
    if tables:
        csv_tables.write(design, folder / TABLES)
    evaluations = {OWN: own, **rivals}
    page = rendered(
        "report.html.j2",
        scenario=scenario,
        design=design,
        summary=_summary(scenario, own, rivals),
        names=list(evaluations),
        scores=_scores(scenario, evaluations),
        measure=_measure(scenario.judge()),
        contour=own.contour is not None,
        response=contour_plots.motion(own, f"{OWN} on {scenario.name}"),
        errors=plots.errors(evaluations),
        sections=_sections(design, own, scenario),
        tables=tables,
        search=_found(search, scenario) if search else None,
        provenance={
            key: value if isinstance(value, str) else json.dumps(value)
            for key, value in design.provenance.items()
            if key != "scenario"  # the configuration has it
        },
        config=(folder / CONFIG).read_text(encoding="utf-8"),
    )
    write_whole(folder / REPORT, page)


def _found(search: Search, scenario: Scenario) -> dict[str, Any]:
    """How the design was found."""
    hierarchy = isinstance(scenario.controller, HierarchicalSettings)
    return {
        "generations": search.generation,
        "diverged": int(search.history.diverged.sum()),
        "title": scenario.judge().title,
        "history": plots.history(search.history, scenario.judge().title),
        "structures": hierarchical.structures(search.archive, scenario) if hierarchy else None,
    }


def _sections(design: Design, own: Evaluation, scenario: Scenario) -> list[Section]:
    """What there is to say about a controller of this kind."""
    if isinstance(design.controller, HierarchicalDesign):
        return hierarchical.sections(design)
    if isinstance(design.controller, FuzzyRecord):
        return fuzzy.sections(design, own, scenario)
    return gains.sections(design)


def _summary(scenario: Scenario, own: Evaluation, rivals: Mapping[str, Evaluation]) -> str:
    """What the run achieved, in a sentence."""
    if own.diverged:
        return f"The controller diverges on {scenario.name}."
    line = f"The controller reaches {_achieved(own)} on {scenario.name}"
    parts = [_compared(own, rivals[key], name) for key, name in PUBLISHED.items() if key in rivals]
    if not parts:
        return f"{line}."
    *others, last = parts
    return f"{line}: {', '.join(others)}{' and ' if others else ''}{last}."


def _achieved(found: Evaluation) -> str:
    if found.contour is None:
        return f"a fitness of {score(found.fitness)}"
    return f"a contour error of {_rms(found):.3g} BLU rms"


def _compared(own: Evaluation, rival: Evaluation, name: str) -> str:
    if rival.diverged:
        return f"{name} diverges there"
    if own.contour is None:
        if min(own.fitness, rival.fitness) <= 0.0:
            return f"that of {name} is {score(rival.fitness)}"
        factor = own.fitness / rival.fitness
        return f"{factor:.3g} times that of {name}, which is {score(rival.fitness)}"
    its = _rms(rival)
    return f"that of {name} is {its / _rms(own):.3g} times as large ({its:.3g} BLU)"


def _rms(found: Evaluation) -> float:
    """Root mean square of the contour error [BLU] of a motion that did not diverge."""
    value = found.metrics["rms_contour_error_BLU"]
    assert value is not None
    return value


def _measure(judge: Judge) -> str:
    """What the fitness is, and what designs are ranked by."""
    fitness = judge.objectives[0]
    told = f"The fitness is {fitness.meaning or f'{fitness.name}, an own one'}"
    return told + (f"; designs are ranked by {judge.title}" if "merit" in judge.titles else "")


def _scores(scenario: Scenario, evaluations: Mapping[str, Evaluation]) -> Rows:
    """Fitness, merit and metrics, a row each; a column for each evaluation."""
    found = evaluations.values()
    rows = []
    for key, title in scenario.judge().titles.items():
        scores = ("diverged" if x.diverged else f"{getattr(x, key):.4f}" for x in found)
        rows.append([title, *scores])
    first = next(iter(found))
    told = meanings(scenario)
    for key in first.metrics:
        values = (item.metrics[key] for item in found)
        rows.append([told[key], *("–" if value is None else f"{value:.4g}" for value in values)])
    return rows
