"""Tables of ``Usable.numbers``: the motions, the stress tests, what would give a yes."""

import re
from collections.abc import Iterable, Sequence

from hfc_design.core.numbers import Json
from hfc_design.core.tables import MISSING, Table
from hfc_design.core.wording import three_digits
from hfc_design.plotting.numbers import readable

#: Titles of the metrics of tracking.
TITLES = {
    "settled_rms_error": "settled rms error",
    "estimated_rms_contour_error": "estimated rms contour error",
}
#: Captions of ``motions_table``, ``stress_table`` and ``why_table``.
MOTIONS_ABOUT = (
    "{} machines that the search did not use, with parameters within ±{:g} %: the share that "
    "passes, and median / {}."
)
OF_ALL, OF_FIRST = (
    "largest of each quantity",
    "95th percentile of the error, median / largest of chatter and peak, largest share at a limit",
)
STRESS_ABOUT = (
    "Conditions beyond the scenario. Stress: one at a time, on machines that are stable without "
    "it, in all motions required of them; stable: of the constraints only late_error counts here; "
    "merit: of the median machine, relative to that without stress."
)
#: Pattern of the name of a stress -> advice if it breaks a design first; "": any other stress.
MENDS = {
    "mode": "record a log with higher frequencies and run hfc identify again, also with two masses",
    "delay|loop|early": "identify delay and lag, or filter less (a faster observer)",
    "standstill": "identify it too (--free stiction_rise,...), from a log with slow reversals",
    "noise": 'sensors.velocity = "observer", a slower observer_hz, or a better encoder',
    "friction": "give friction_moving a tolerance in [robust.tolerances] and search again",
    "start|rest|backwards": "add a motion that does so and search again",
    "": "give it a tolerance in [robust.tolerances] and search again",
}
WHY = "Changes that would give a yes, each on its own"
WHY_ABOUT = (
    "Lost by it: machines that fail it, some also for other reasons; without: share that passes "
    "without it (of spread and tolerances: share within half of them); –: no value suffices alone; "
    "(n): number of machines within. The stress tests must pass as well."
)
#: Explanation of the columns of ``motions_table``.
COLUMNS = (
    "settled: after settled_after_s of the scenario; chatter: rms change of the command from one "
    "sample to the next; peak: largest command; at a limit: share of the last quarter of the "
    "motion with the command at its limit",
)
#: A number that no metric of a working drive reaches, in any unit of a table.
RUNAWAY = 1e9


def tables(numbers: Json) -> list[Table]:
    """Return the tables of ``Usable.numbers``: what would give a yes, the motions, the stress."""
    why = [why_table(numbers["why_not"])] if numbers.get("why_not") else []
    stress = [stress_table(numbers["stress"])] if numbers.get("stress") else []
    return [*why, motions_table(numbers), *stress]


def motions_table(numbers: Json, largest: bool = False) -> Table:
    """Return the table of motions: a row for each, with the share that passes and all metrics.

    With ``largest`` a cell has median and largest value of a metric, otherwise see ``OF_FIRST``.
    """
    tracked = "median", "largest" if largest else "q95"
    motions, tracking = numbers["motions"], next(iter(numbers["units"]))
    columns = [*zip(*(one["measures"].values() for one in motions.values()), strict=True)]
    scales = []  # factor and unit of each metric in which the medians of all motions are readable
    for unit, column in zip([*numbers["units"].values(), "1"], columns, strict=True):
        medians = (abs(one["median"]) for one in column if one["median"])
        scales.append(readable(unit, min(medians, default=1.0)))
    titles = TITLES.get(tracking, tracking), "chatter", "peak command", "share at a limit"
    units = (f"{title} [{unit}]" for title, (_, unit) in zip(titles, scales, strict=True))
    rows = []
    for name, one in motions.items():
        row = [name + " *" * (one.get("asked_of") == "nominal"), f"{100 * one['share']:.4g}"]
        for (key, measure), (factor, _) in zip(one["measures"].items(), scales, strict=True):
            which = [*tracked] if key == tracking else ["median", "largest"]
            which = which[1:] if key == "limit_share" and not largest else which
            row.append(" / ".join(_shown(measure[x], factor) for x in which))
        rows.append(row)
    of = OF_ALL if largest else OF_FIRST
    about = MOTIONS_ABOUT.format(numbers["machines"], 100 * numbers["spread"], of)
    return Table(about, ["motion", "pass [%]", *units], rows, lines=COLUMNS)


def _shown(value: float | None, factor: float) -> str:
    """Return the text of a metric times ``factor``; "diverges" for an impossibly large one."""
    if value is None:
        return MISSING
    return "diverges" if abs(factor * value) >= RUNAWAY else three_digits(factor * value)


def why_table(analysis: Json) -> Table:
    """Return the table of ``why_not``, with a row for each change."""
    head = ("change", "now", "for a yes", "lost by it", "pass without [%]")
    keys = ("key", "now", "needed", "lost")
    each = [([str(x[key] or MISSING) for key in keys], x["without"]) for x in analysis["changes"]]
    rows = [[*row, f"{100 * without:.3g}"] for row, without in each]
    return Table(WHY_ABOUT, head, rows, lines=analysis["lines"])


def stress_table(stresses: Sequence[Json]) -> Table:
    """Return the table of stresses, with lines on those that break the design (see ``_broken``)."""
    each = ((x, f"{x['merit'] or 0.0:.2f}" if x["holds"] else "breaks") for x in stresses)
    rows = [[one["name"], f"{100 * one['share']:.3g}", merit] for one, merit in each]
    lines = [
        f"breaks: {failure}" + (part and f"; it is stable with {part}")
        for failure, part in _broken(stresses)
    ]
    if lines:
        first = (x for words, x in MENDS.items() if re.search(words, lines[0].split(" it ")[0]))
        lines.append(f"first step: {next(first)}; see docs/robustness.md")
    head = ("stress", "stable on [%]", "merit [times]")
    return Table(STRESS_ABOUT, head, rows, lines=lines)


def breaking(stresses: Iterable[Json]) -> str:
    """Return a text on the stress that breaks a design first, and how many others do; "": none."""
    first, *more = [failure for failure, _ in _broken(stresses)] or [""]
    others = f", and {len(more)} more stress{'es break' if len(more) > 1 else ' breaks'} it"
    return first + (others if more else "")


def _broken(stresses: Iterable[Json]) -> list[tuple[str, str]]:
    """Return two texts for each stress that breaks the design: how, and which part does not."""
    each = sorted((one for one in stresses if not one["holds"]), key=lambda one: float(one["part"]))
    return [(f"with {one['breaks']} it {one['why']}", one.get("held", "")) for one in each]
