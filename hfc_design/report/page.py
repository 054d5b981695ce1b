"""The report of a run: one page that needs nothing else, and the rule tables as CSV."""

import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers.kind import Shown
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.numbers import Json
from hfc_design.core.plugins import own_code, uses
from hfc_design.core.records import RunError, UserError
from hfc_design.files.design import Design
from hfc_design.files.machine import SensorSettings
from hfc_design.files.pairing import load_design, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.formats import FORMATS
from hfc_design.objectives.judge import Judge
from hfc_design.pictures.figure import Listing, Section, score
from hfc_design.report import REPORT, batch_plots, plots, rendered, trade_off
from hfc_design.report.comparison.tables import NONE, short
from hfc_design.runs.attained import HEADS, attained_rows, attained_told, kept_attained, left_out
from hfc_design.runs.individuals import genome_of
from hfc_design.runs.polishing import polish_told
from hfc_design.runs.run import CONFIG, Result, used
from hfc_design.search.loop import Archive
from hfc_design.simulation.evaluating import evaluate, meanings
from hfc_design.simulation.evaluation import Evaluation
from hfc_design.simulation.gain_range import gain_told
from hfc_design.simulation.in_use import merit_told, several
from hfc_design.simulation.repeats import range_told
from hfc_design.simulation.score_tables import score_rows

TABLES = "tables"
Evaluations = dict[str, Evaluation]  # by the names of the designs
OWN = "this design"
#: Units that numbers of this size are not read in -> factor to one that they are, and that one.
SHOWN_IN = {"rad": (1e6, "µrad")}
#: This many structures are listed.
BEST = 10


class Baseline(NamedTuple):
    """What a published design is called."""

    short: str  # in the table
    name: str = ""  # in the summary; "": it is not compared with there


#: Plant -> built-in designs shown beside every result.
BASELINES = {
    "five-axis": {"lin-gai-2009-pid": Baseline("LG PID", "the PID of Lin & Gai (2009)")},
    "c-axis": {
        "lin-lee-1999-table-1": Baseline("LL Table I", "Table I of Lin & Lee (1999)"),
        "lin-lee-1999-table-2": Baseline("LL Table II", "Table II"),
        "pd-only": Baseline("PD only"),
    },
    "feed-drive": {
        "jee-koren-2004-aflc": Baseline("JK04 AFLC", "the AFLC of Jee & Koren (2004)"),
        "jee-koren-2004-flc": Baseline("JK04 FLC", "their FLC"),
        "jee-koren-2004-pid": Baseline("JK04 PID", "their PID"),
    },
    "milling-table": {
        "huang-soc": Baseline("Huang SOC", "the SOC of Huang & Shy"),
        "huang-pid": Baseline("Huang PID", "their PID"),
    },
    "positioning-stage": {
        "emps-cascade": Baseline("EMPS cascade", "the loop that recorded the logs of EMPS"),
    },
}


def write_page(
    scenario: Scenario, result: Result, folder: Path, rivals: Evaluations | None = None
) -> Evaluations:
    """Write ``report.html`` and ``tables/`` into the run folder; returns the ``rivals``.

    These are other designs on the same scenario, the published ones if none are given. The page
    has everything inside it, and the same run gives the same bytes.

    Raises:
        RunError: the folder cannot be written.
    """
    if rivals is None:
        rivals = {}
        for name in BASELINES.get(scenario.plant.name, {}):
            with suppress(UserError):  # it does not fit the plant or the sampling
                rivals[name] = evaluate(load_design(name), scenario)
    design, own, search, front = result
    tables = all(part.kind.rules for part in design.by_axis().values())
    if tables:
        if (folder / TABLES).is_symlink():  # of others' files none is overwritten
            raise RunError(f"{folder / TABLES}: is a link; remove it, tables are not written there")
        FORMATS["csv"].write(design, folder / TABLES)
    evaluations, told = {OWN: own, **rivals}, meanings(scenario)
    scores = score_rows(scenario.judge(), [*evaluations.values()], ".4g", "–")
    page = rendered(
        "report.html.j2",
        scenario=scenario,
        design=design,
        summary=_summary(scenario, own, rivals),
        polished=polish_told(design),
        names=list(evaluations),
        scores=[[told.get(key, key), *row] for key, *row in scores],
        measure=_measure(scenario.judge()),
        contour=own.contour is not None and not own.contour.any_axes,
        attained=_attained(folder),
        used=_used(scenario, result, folder),
        several=_motions(own, scenario),
        response=plots.motion(own, f"{OWN} on {scenario.name}"),
        errors=(plots.motion_errors if own.motions else plots.errors)(evaluations),
        sections=_sections(design, own, scenario),
        front=front and trade_off.section(front),
        tables=tables,
        search=search,
        history=search and batch_plots.history(search.history, scenario.judge().title),
        structures=search and _structures(search.archive, scenario),
        own_parts=uses(design.provenance.get("plugins")),
        provenance={
            key: value if isinstance(value, str) else json.dumps(value)
            for key, value in design.provenance.items()
            if key != "scenario"  # the configuration has it
        },
        config=(folder / CONFIG).read_text(encoding="utf-8"),
    )
    write_whole(folder / REPORT, page)
    return rivals


def _used(scenario: Scenario, result: Result, folder: Path) -> Json | None:
    """What the run says of whether its design can be used; None if nobody can say."""
    try:
        found = used(scenario, result, folder)
        told = [SHOWN_IN.get(unit, (1.0, unit)) for unit in found["units"].values()]
        factors = [*(factor for factor, _ in told), 1.0]
        named = zip(("error once settled", "chatter", "peak command"), told, strict=True)
        heads = ["motion", "keep all [%]", *(f"{name} [{unit}]" for name, (_, unit) in named)]
        each = found["motions"].items()
        return found | {
            "heads": [*heads, "share at a limit [1]"],
            "rows": [_used_row(name, one, factors) for name, one in each],
            "others": {name: why for name, one in each if (why := _why_others(one))},
            "alone": any(one.get("asked_of") == "nominal" for _, one in each),
            "gain_told": found["gain"] and gain_told(found["gain"]),
            "chaos_told": merit_told(found),
        }
    # ... or the file has been edited
    except (UserError, KeyError, TypeError, AttributeError, ValueError):
        return None


def _attained(folder: Path) -> Json | None:
    """How near the design comes to what any controller could do; None if nobody has asked."""
    found = kept_attained(folder)
    if found is None:
        return None
    own = {"told": attained_told(found), "left_out": left_out(found), "rows": attained_rows(found)}
    return own | {"heads": ["motion", *HEADS]}


def _used_row(name: str, found: Json, factors: Sequence[float]) -> list[str]:
    """Name, share, and of each measure the median and the largest, times its factor."""
    cells = []
    for one, factor in zip(found["measures"].values(), factors, strict=True):
        pair = (one["median"], one["largest"])
        cells.append(" / ".join(NONE if x is None else short(factor * x) for x in pair))
    mark = " *" if found.get("asked_of") == "nominal" else ""
    return [name + mark, f"{100 * found['share']:.4g}", *cells]


def _why_others(found: Json) -> str:
    """Why machines do not keep everything in a motion, the most frequent first; "" if all do."""
    reasons = sorted(found["reasons"].items(), key=lambda item: -item[1])
    told = (f"{count} {reason if count == 1 else several(reason)}" for reason, count in reasons)
    return ", ".join(told)


def _motions(own: Evaluation, scenario: Scenario) -> list[Figure]:
    """A picture of all motions, or, on paths and of several axes, one of each."""
    if len(own.axes) == 1 and own.motions:
        return [plots.motions(own, f"{OWN} on {scenario.name}")]
    return [plots.motion(one, f"{OWN} in {name}") for name, one in own.motions.items()]


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


def _summary(scenario: Scenario, own: Evaluation, rivals: Evaluations) -> str:
    """What the run achieved, in a sentence."""
    if own.diverged:
        return f"The controller diverges on {scenario.name}{_why(own)}."
    achieved = f"a fitness of {_fitness(own)[1]}"
    if own.contour is not None:
        achieved = f"a contour error of {_rms(own):.3g} {own.contour.unit} rms"
    line = f"The controller reaches {achieved} on {scenario.name}"
    if own.substeps > scenario.simulation.substeps:
        line += f" (simulated with {own.substeps} substeps, it diverges with fewer)"
    known = BASELINES.get(scenario.plant.name, {})
    names = {key: known[key].name for key in known if key in rivals}
    parts = [_compared(own, rivals[key], name) for key, name in names.items() if name]
    if not parts:
        return f"{line}."
    *others, last = parts
    return f"{line}: {', '.join(others)}{' and ' if others else ''}{last}."


def _compared(own: Evaluation, rival: Evaluation, name: str) -> str:
    if rival.diverged:
        return f"{name} diverges there{_why(rival)}"
    if own.contour is None:
        mine, (theirs, told) = _fitness(own)[0], _fitness(rival)
        if min(mine, theirs) <= 0.0:
            return f"that of {name} is {told}"
        return f"{mine / theirs:.3g} times that of {name}, which is {told}"
    its = f"{_rms(rival):.3g} {own.contour.unit}"
    factor = _rms(rival) / _rms(own) if _rms(own) else np.inf
    if not 0 < factor < np.inf:
        return f"that of {name} is {its}"
    return f"that of {name} is {factor:.3g} times as large ({its})"


def _fitness(found: Evaluation) -> tuple[float, str]:
    """What it counts as, where it is chaotic its lower end, and how people read it."""
    if (many := found.ranges.get("fitness")) is None:
        return found.fitness, score(found.fitness)
    return found.repeats["fitness"].lowest, range_told(many)


def _why(lost: Evaluation) -> str:
    return f": {lost.divergence}" if lost.divergence else ""


def _rms(found: Evaluation) -> float:
    """Root mean square of the contour error of a motion that did not diverge."""
    value = next(iter(found.metrics.values()))
    return np.inf if value is None else value  # too large for its square


def _measure(judge: Judge) -> str:
    """What the fitness is, and what designs are ranked by."""
    fitness = judge.objectives[0]
    told = f"The fitness is {fitness.meaning or f'{fitness.name}, an own one'}"
    return told + (f"; designs are ranked by {judge.title}" if "merit" in judge.titles else "")
