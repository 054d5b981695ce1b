"""The report of a run: one page that needs nothing else, and the rule tables as CSV."""

import base64
import json
from collections.abc import Mapping
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from hfc_design import fitness
from hfc_design.checkpoint import write_whole
from hfc_design.design import CONFIG, Result
from hfc_design.evaluate import Evaluation
from hfc_design.export import csv_tables
from hfc_design.paths.metrics import CONTOUR_METRICS
from hfc_design.pictures import contour_plots, plots
from hfc_design.report import fuzzy, hierarchical
from hfc_design.report.section import Rows, score
from hfc_design.rulebase import HierarchicalDesign
from hfc_design.scenarios import ContourSettings, Scenario

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
        UserError: the design is of a kind without rule tables.
    """
    csv_tables.write(result.design, folder / TABLES)
    design, own, search = result
    hierarchy = isinstance(design.controller, HierarchicalDesign)
    evaluations = {OWN: own, **rivals}
    environment = Environment(
        loader=PackageLoader("hfc_design"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters["picture"] = _picture
    page = environment.get_template("report.html.j2").render(
        scenario=scenario,
        design=design,
        summary=_summary(scenario, own, rivals),
        names=list(evaluations),
        scores=_scores(evaluations),
        measure=_measure(scenario),
        contour=own.contour is not None,
        response=contour_plots.motion(own, f"{OWN} on {scenario.name}"),
        errors=plots.errors(evaluations),
        sections=(
            hierarchical.sections(design) if hierarchy else fuzzy.sections(design, own, scenario)
        ),
        generations=search.generation,
        diverged=int(search.history.diverged.sum()),
        history=plots.history(search.history),
        structures=hierarchical.structures(search.archive, scenario) if hierarchy else None,
        provenance={
            key: value if isinstance(value, str) else json.dumps(value)
            for key, value in design.provenance.items()
            if key != "scenario"  # the configuration has it
        },
        config=(folder / CONFIG).read_text(encoding="utf-8"),
    )
    write_whole(folder / REPORT, page.encode())


def _picture(figure: Figure) -> str:
    """A figure as the address of an image, so that its names cannot clash with the page's."""
    return "data:image/svg+xml;base64," + base64.b64encode(plots.image(figure, "svg")).decode()


def _summary(scenario: Scenario, own: Evaluation, rivals: Mapping[str, Evaluation]) -> str:
    """What the run achieved, in a sentence."""
    if own.diverged:
        return f"Every controller that the search found diverges on {scenario.name}."
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
        factor = own.fitness / rival.fitness
        return f"{factor:.3g} times that of {name}, which is {score(rival.fitness)}"
    its = _rms(rival)
    return f"that of {name} is {its / _rms(own):.3g} times as large ({its:.3g} BLU)"


def _rms(found: Evaluation) -> float:
    """Root mean square of the contour error [BLU] of a motion that did not diverge."""
    value = found.metrics["rms_contour_error_BLU"]
    assert value is not None
    return value


def _measure(scenario: Scenario) -> str:
    """What the fitness is, in a sentence."""
    settings = scenario.fitness
    if isinstance(settings, ContourSettings):
        of = f"1 / (rms + {settings.worst:g} × largest + {settings.lag:g} × rms lag)"
        return f"The fitness is {of} of the contour error [1/BLU]"
    return "The fitness is eq. 5 of Lin & Lee (1999)"


def _scores(evaluations: Mapping[str, Evaluation]) -> Rows:
    """Fitness and metrics, a row each; a column for each evaluation."""
    found = evaluations.values()
    rows = [
        ["fitness", *("diverged" if item.diverged else f"{item.fitness:.4f}" for item in found)]
    ]
    first = next(iter(found))
    meanings = fitness.meanings(first.plant) if first.contour is None else CONTOUR_METRICS
    for key in first.metrics:
        meaning = meanings[key]
        values = (item.metrics[key] for item in found)
        rows.append([meaning, *("–" if value is None else f"{value:.4g}" for value in values)])
    return rows
