"""The report of a run: a self-contained page, and the rule tables as CSV."""

import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from textwrap import shorten
from typing import Any

from hfc_design.core.numbers import Json
from hfc_design.core.plugins import uses
from hfc_design.core.records import RunError, UserError
from hfc_design.core.wording import percent
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import scenario_toml
from hfc_design.files.plausibility import plausibility_warnings
from hfc_design.files.scenario import Scenario
from hfc_design.files.transfer import dotted
from hfc_design.formats import FORMATS
from hfc_design.plotting.numbers import metric
from hfc_design.report import REPORT, Page, parts, plots, rendered, searches, trade_off
from hfc_design.report.errors import errors, motion_errors
from hfc_design.report.paper import Paper, write_with_parts
from hfc_design.report.parts import Evaluations
from hfc_design.runs.polishing import polish_told
from hfc_design.runs.run import CONFIG, Result, used
from hfc_design.simulation import acceptance, usable_tables
from hfc_design.simulation.evaluating import Evaluation, evaluate, meanings
from hfc_design.simulation.stability_criteria import EXPLAINED, reasons_text
from hfc_design.simulation.usable import usable

TABLES = "tables"
OWN = "this design"
#: Content that the page of a single design lacks.
OF_RUNS = "run", "tables", "attained", "front", "search", "history", "structures"
#: Largest number of letters of a text on the origin of a design; the rest is in the design file.
LONGEST = 400


def write_page(
    scenario: Scenario,
    result: Result,
    folder: Path,
    rivals: Evaluations | None = None,
    paper: Paper | None = None,
) -> Evaluations:
    """Write ``report.html`` and ``tables/`` into the run folder; return the ``rivals``.

    The rivals are other designs on the same scenario; default: the published ones. The page is
    self-contained, and the same run gives the same bytes; ``paper`` selects its figures and tables
    for a paper.

    Raises:
        RunError: the folder cannot be written.
    """
    rivals = _published(scenario) if rivals is None else rivals
    design, evaluation, search, front = result
    tables = all(part.kind.rule_base for part in design.by_axis().values())
    if tables:
        if (folder / TABLES).is_symlink():  # no file elsewhere is overwritten
            raise RunError(f"{folder / TABLES}: must not be a link; remove it")
        FORMATS["csv"].write(design, folder / TABLES)
    options = uses(design.provenance.get("plugins"))
    again = f"hfc design config.toml{options} --out another-folder"
    page = _rendered(
        scenario,
        design,
        evaluation,
        rivals,
        used=lambda: used(scenario, result, folder),
        of=folder.resolve().name,
        attained=parts.how_near(folder),
        front=front and trade_off.section(front),
        run=True,
        tables=tables,
        search=search,
        history=search and searches.history(search.history, scenario.judge().title),
        structures=search and parts.best_structures(search.archive, scenario),
        again=again if search else f"hfc score given.json --scenario config.toml{options}",
        config=(folder / CONFIG).read_text(encoding="utf-8"),
    )
    write_with_parts(folder / REPORT, page, paper)
    return rivals


def design_page(
    design: Design, scenario: Scenario, again: str, rivals: Evaluations | None = None
) -> Page:
    """Return the page of a design on a scenario: the page of a run without the search.

    Args:
        design: subject of the page.
        scenario: the scenario that it was made for, or another.
        again: the command that repeats this evaluation.
        rivals: other designs on the scenario; default: the published ones.

    Raises:
        UserError: the design does not run on the scenario.
    """
    evaluation = evaluate(design, scenario)  # before the rivals, as it may be refused
    if rivals is None:
        rivals = _published(scenario)
        rivals.pop(design.name, None)
    return _rendered(
        scenario,
        design,
        evaluation,
        rivals,
        used=lambda: usable(design, scenario).numbers(),
        of=design.name,
        again=again,
        config=scenario_toml(scenario),
    )


def _published(scenario: Scenario) -> Evaluations:
    """Return evaluations of the published designs for the scenario's plant that fit."""
    rivals = {}
    for name in parts.baselines(scenario):
        with suppress(UserError):  # it does not fit the plant or the sampling
            rivals[name] = evaluate(load_design(name), scenario)
    return rivals


def _rendered(
    scenario: Scenario,
    design: Design,
    evaluation: Evaluation,
    rivals: Evaluations,
    used: Callable[[], Json],
    of: str,
    **others: Any,
) -> Page:
    """Return the page of a design on a scenario; ``of`` names the run, or the single design."""
    missing: dict[str, Any] = dict.fromkeys(OF_RUNS)
    evaluations = {OWN: evaluation, **rivals}
    scores, others_shown = parts.score_tables(scenario, evaluations)
    usable = parts.whether_used(used)
    motions = usable["motions"] if usable else {}
    failing = {name: reasons_text(one["reasons"]) for name, one in motions.items()}
    return rendered(
        "report.html.j2",
        f"{of} on {scenario.name}",
        scenario=scenario,
        design=design,
        kind=design.kind.name,
        summary=parts.summary(scenario, evaluation, rivals, bool(usable and usable["usable"])),
        polished=polish_told(design),
        names=list(evaluations),
        scores=scores,
        others=others_shown,
        meant=[(metric(key, text)[0], text) for key, text in meanings(scenario).items()],
        contour=evaluation.contour is not None and not evaluation.contour.any_axes,
        used=usable,
        failing={name: why for name, why in failing.items() if why},
        asked=[one.get("asked_of") for one in motions.values()],
        everything=parts.pass_conditions(scenario),
        doubts=plausibility_warnings(scenario),
        chaotic=evaluation.chaotic,
        several={
            name: plots.motion(one, f"{OWN} in {name}") for name, one in evaluation.motions.items()
        },
        response=plots.motion(evaluation, f"{OWN} on {scenario.name}"),
        errors=(motion_errors if evaluation.motions else errors)(evaluations),
        sections=parts.sections(design, evaluation, scenario),
        provenance=_made(design),
        reasons=EXPLAINED,
        percent=percent,
        use=acceptance,
        of_use=usable_tables,
        **missing | others,
    )


def _made(design: Design) -> dict[str, str]:
    """Return the origin of a design without the scenario: key -> a text of one line."""
    origin = dotted({key: x for key, x in design.provenance.items() if key != "scenario"})
    texts = {
        key: x if isinstance(x, str) else json.dumps(x, ensure_ascii=False)
        for key, x in origin.items()
    }
    return {key: shorten(text, LONGEST, placeholder=" …") for key, text in texts.items()}
