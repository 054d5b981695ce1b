"""The report of a run: one page that needs nothing else, and the rule tables as CSV."""

import json
import shlex
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from hfc_design.controllers.kind import Shown
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.numbers import Json
from hfc_design.core.plugins import own_code, uses
from hfc_design.core.records import RunError, UserError
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.machine import SensorSettings
from hfc_design.files.named_scenario import scenario_toml
from hfc_design.files.pairing import load_design, own_scenario, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.formats import FORMATS
from hfc_design.pictures.figure import Listing, Section, score
from hfc_design.report import REPORT, batch_plots, plots, rendered, trade_off
from hfc_design.report.in_use import in_use
from hfc_design.report.verdict import BASELINES, Evaluations, measure, summary
from hfc_design.runs.attained import HEADS, attained_rows, attained_told, kept_attained, left_out
from hfc_design.runs.individuals import genome_of
from hfc_design.runs.polishing import polish_told
from hfc_design.runs.run import CONFIG, Result, used
from hfc_design.search.loop import Archive
from hfc_design.simulation.evaluating import evaluate, meanings
from hfc_design.simulation.evaluation import Evaluation
from hfc_design.simulation.score_tables import score_rows
from hfc_design.simulation.usable import usable

TABLES = "tables"
OWN = "this design"
#: This many structures are listed.
BEST = 10


def write_page(
    scenario: Scenario, result: Result, folder: Path, rivals: Evaluations | None = None
) -> Evaluations:
    """Write ``report.html`` and ``tables/`` into the run folder; returns the ``rivals``.

    These are other designs on the same scenario, the published ones if none are given. The page
    has everything inside it, and the same run gives the same bytes.

    Raises:
        RunError: the folder cannot be written.
    """
    rivals = _published(scenario) if rivals is None else rivals
    design, own, search, front = result
    tables = all(part.kind.rules for part in design.by_axis().values())
    if tables:
        if (folder / TABLES).is_symlink():  # of others' files none is overwritten
            raise RunError(f"{folder / TABLES}: is a link; remove it, tables are not written there")
        FORMATS["csv"].write(design, folder / TABLES)
    options = uses(design.provenance.get("plugins"))
    again = f"hfc design config.toml{options} --out another-folder"
    page = _rendered(
        scenario,
        design,
        own,
        rivals,
        used=lambda: used(scenario, result, folder),
        attained=_attained(folder),
        front=front and trade_off.section(front),
        run=True,
        tables=tables,
        search=search,
        history=search and batch_plots.history(search.history, scenario.judge().title),
        structures=search and _structures(search.archive, scenario),
        again=again if search else f"hfc score given.json --scenario config.toml{options}",
        config=(folder / CONFIG).read_text(encoding="utf-8"),
    )
    write_whole(folder / REPORT, page)
    return rivals


def design_page(name: AnyDesign, rivals: Evaluations | None = None) -> bytes:
    """The page of a lone design on its own scenario: that of a run without how it was found.

    ``rivals`` are other designs on that scenario, the published ones if none are given.

    Raises:
        UserError: there is no such design, or it does not run on its scenario.
    """
    design = load_design(name)
    called = design.name if name is design else str(name)
    scenario = own_scenario(design, called)
    if rivals is None:
        rivals = _published(scenario)
        rivals.pop(design.name, None)
    return _rendered(
        scenario,
        design,
        evaluate(design, scenario),
        rivals,
        used=lambda: usable(design, scenario).numbers(),
        attained=None,
        front=None,
        run=False,
        tables=False,
        search=None,
        history=None,
        structures=None,
        again=f"hfc score {shlex.quote(called)}{uses(design.provenance.get('plugins'))}",
        config=scenario_toml(scenario),
    )


def _published(scenario: Scenario) -> Evaluations:
    """What the published designs for its plant do, those that fit it."""
    found = {}
    for name in BASELINES.get(scenario.plant.name, {}):
        with suppress(UserError):  # it does not fit the plant or the sampling
            found[name] = evaluate(load_design(name), scenario)
    return found


def _rendered(
    scenario: Scenario,
    design: Design,
    own: Evaluation,
    rivals: Evaluations,
    used: Callable[[], Json],
    **others: Any,
) -> bytes:
    """The page of a design on a scenario, of a run or by itself."""
    evaluations, told = {OWN: own, **rivals}, meanings(scenario)
    scores = score_rows(scenario.judge(), [*evaluations.values()], ".4g", "–")
    first = _first(own, scenario)
    return rendered(
        "report.html.j2",
        scenario=scenario,
        design=design,
        kind=design.kind.name,
        summary=summary(scenario, own, rivals),
        polished=polish_told(design),
        names=list(evaluations),
        scores=[[told.get(key, key), *row] for key, *row in scores if key in first],
        others=[[told.get(key, key), *row] for key, *row in scores if key not in first],
        measure=measure(scenario.judge()),
        contour=own.contour is not None and not own.contour.any_axes,
        used=_used(used),
        several=[plots.motion(one, f"{OWN} in {name}") for name, one in own.motions.items()],
        response=plots.motion(own, f"{OWN} on {scenario.name}"),
        errors=(plots.motion_errors if own.motions else plots.errors)(evaluations),
        sections=_sections(design, own, scenario),
        provenance={
            key: value if isinstance(value, str) else json.dumps(value)
            for key, value in design.provenance.items()
            if key != "scenario"  # the configuration has it
        },
        **others,
    )


def _first(own: Evaluation, scenario: Scenario) -> Collection[str]:
    """What stands in the first table: all, or of several motions what counts and their errors."""
    if not own.motions:
        return [*scenario.judge().titles.values(), *own.metrics]
    each = own.motions.items()
    errors = (f"{name.replace('-', '_')}_{next(iter(one.metrics))}" for name, one in each)
    return [*scenario.judge().titles.values(), *errors]


def _used(numbers: Callable[[], Json]) -> Json | None:
    """Whether a design can be used; None if nobody can say, or what says so was edited."""
    with suppress(UserError, KeyError, TypeError, AttributeError, ValueError):
        return in_use(numbers())
    return None


def _attained(folder: Path) -> Json | None:
    """How near the design comes to what any controller could do; None if nobody has asked."""
    found = kept_attained(folder)
    if found is None:
        return None
    own = {"told": attained_told(found), "left_out": left_out(found), "rows": attained_rows(found)}
    return own | {"heads": ["motion", *HEADS]}


def _structures(archive: Archive, scenario: Scenario) -> Listing | None:
    """The best structures of the search and their scores; None where there is but one."""
    genome = genome_of(scenario)
    if genome.structures == 1:
        return None
    best = (-archive.score).argsort(kind="stable")[:BEST]
    order = best[np.isfinite(archive.score[best])]
    trees = archive.population.tree
    return Listing(
        "The best structures, each with the best that the search "
        f"(in {scenario.run.precision}) found for it; the controller above is the best of them in "
        "float64. A unit is written (column input, row input).",
        ["structure", scenario.judge().title],
        [[genome.notation(int(trees[k])), score(archive.score[k])] for k in order],
    )


def _sections(design: Design, own: Evaluation, scenario: Scenario) -> list[Section]:
    """What there is to say about a controller of this kind; UserError: a user's own cannot."""
    plant = scenario.plant
    # With sensors of the scenario's own nobody knows what the control has measured.
    known = scenario.sensors == SensorSettings() and not own.diverged
    signals = {axis.name: axis.told() for axis in own.axes} if known else None
    limits, axes = with_converter(scenario, design).limits, plant.machine.axes
    delays = tuple(limits.of(axis).delay_samples for axis in axes)
    largest = tuple(design.limits.of(axis).command for axis in axes)
    shown = Shown(plant.machine, plant.values(), signals, delays, largest)
    kinds = [("controller", part.kind.name) for part in (design, *design.by_axis().values())]
    with own_code(", sections of the report (the design is saved)", *kinds):
        return [Section(*section) for section in design.kind.sections(design.controller, shown)]
