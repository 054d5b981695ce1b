"""The report of a run: one page that needs nothing else, and the rule tables as CSV."""

import base64
import json
from collections.abc import Mapping
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from hfc_design import fitness, hierarchy
from hfc_design.checkpoint import write_whole
from hfc_design.design import CONFIG, Result
from hfc_design.evaluate import Evaluation
from hfc_design.export import csv_tables
from hfc_design.paths.metrics import CONTOUR_METRICS
from hfc_design.pictures import contour_plots, diagrams, plots
from hfc_design.rulebase import Design
from hfc_design.scenarios import Scenario
from hfc_design.search.loop import Archive
from plants import PLANTS

REPORT, TABLES = "report.html", "tables"
OWN = "this design"
#: What the summary compares with: name of the built-in design -> what a reader calls it.
PUBLISHED = {
    "lin-lee-1999-table-1": "Table I of Lin & Lee (1999)",
    "lin-lee-1999-table-2": "Table II",
}
#: This many structures are listed.
BEST = 10

Rows = list[list[str]]


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
        response=contour_plots.motion(own, f"{OWN} on {scenario.name}"),
        errors=plots.errors(evaluations),
        parameters=_parameters(design),
        tree=diagrams.tree(design),
        rule_tables=diagrams.rule_tables(design),
        generations=search.generation,
        diverged=int(search.history.diverged.sum()),
        history=plots.history(search.history),
        structures=_structures(search.archive, scenario),
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
    line = f"The controller reaches a fitness of {own.fitness:.1f} on {scenario.name}"
    parts = []
    for key, name in PUBLISHED.items():
        rival = rivals.get(key)
        if rival is None:
            continue
        if rival.diverged:
            parts.append(f"the published one of {name} diverges there")
        else:
            factor = own.fitness / rival.fitness
            parts.append(f"{factor:.3g} times that of {name}, which is {rival.fitness:.1f}")
    return f"{line}: {' and '.join(parts)}." if parts else f"{line}."


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


def _parameters(design: Design) -> Rows:
    """Name, value and unit of the PD gains and of the hierarchy's scales."""
    controller = diagrams.hierarchical(design)
    units = PLANTS[design.plant.name].units
    command, error = units["command"], units["error"]
    rows = [
        ("proportional gain", controller.pd.kp, f"{command}/{error}"),
        ("derivative gain", controller.pd.kd, f"{command} s/{error}"),
    ]
    for item in controller.inputs:
        unit = f"per {diagrams.input_unit(design, item.name)}"
        rows.append((f"scale of {diagrams.readable(item.name)}", item.scale, unit))
    rows.append(("scale of the output", controller.output_scale, command))
    return [[name, f"{value:.6g}", unit] for name, value, unit in rows]


def _structures(archive: Archive, scenario: Scenario) -> Rows:
    """The best structures of the search and their scores."""
    names = [diagrams.readable(item.name) for item in scenario.controller.inputs]
    trees = hierarchy.trees(len(names))
    order = [k for k in (-archive.score).argsort(kind="stable")[:BEST] if archive.score[k] > 0]
    return [
        [_notation(trees[archive.population.tree[k]], names), f"{archive.score[k]:.1f}"]
        for k in order
    ]


def _notation(tree: hierarchy.Tree, names: list[str]) -> str:
    """A tree as nested pairs (column input, row input)."""
    values = list(names)
    for unit in tree:
        values.append(f"({values[unit.column]}, {values[unit.row]})")
    return values[-1]
