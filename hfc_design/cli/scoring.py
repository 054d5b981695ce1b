"""What ``hfc design`` and ``hfc score`` say of a design: can it be used, and how good is it?"""

import json
import sys
import time
from collections.abc import Collection, Iterator
from pathlib import Path
from textwrap import fill

import numpy as np
from rich.table import Table

from hfc_design.core.console import ProgressBar, busy, room, show_rows, show_whole
from hfc_design.core.numbers import Json
from hfc_design.core.wording import percent, three_digits
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.tolerances import TolerancesSettings
from hfc_design.simulation import in_use
from hfc_design.simulation.evaluating import Evaluation, evaluate, motion_rows, notes, score_rows
from hfc_design.simulation.in_use import Usable
from hfc_design.simulation.monte_carlo import Robustness, check_draw, robustness
from hfc_design.simulation.repeats import chaos_told
from hfc_design.simulation.settling import reasons_told
from hfc_design.simulation.usable import SPREAD, usable

QUESTION = "Can I use it?"
WARNING = "hfc: warning: the design is not usable as it is"
ONLY = "hfc: warning: the design is usable only where the machine is as in the model"
#: What stands below the table of motions.
ABOUT = (
    "median, 95th percentile, largest: over the machines",
    "settled: after settled_after_s of the scenario; chatter: rms change of the command from one "
    "sample to the next; peak: largest command; at limit: share of the last quarter of the motion "
    "with the command at its limit",
)


def score_one(
    design: Design,
    scenario: Scenario,
    spread: float | None,
    as_json: bool,
    plot: Path | None = None,
    samples: int | None = None,
    seed: int | None = None,
) -> None:
    """``hfc score`` on one scenario: can it be used, where there are tolerances, then how good.

    Raises:
        UserError: a value is not allowed, or design and scenario do not fit.
    """
    found: Usable | Robustness | None = None
    if scenario.robust or (scenario.motions and spread is not None):
        draw = (1 if samples is None else samples, 0 if seed is None else seed)
        check_draw(SPREAD if spread is None else spread, *draw)
        with busy("on machines that no search has seen"):
            found = usable(design, scenario, spread, samples, seed)
    elif spread is not None:
        draw = (1000 if samples is None else samples, 0 if seed is None else seed)
        found = _robustness(design, scenario, spread, *draw)
    if isinstance(found, Robustness):
        _tell_spread(design, scenario, found, as_json)
    elif as_json:
        numbers = _numbers(design, scenario, evaluate(design, scenario))
        print(json.dumps(numbers | ({"can_i_use_it": found.numbers()} if found else {})))
    elif found is None:
        print(f"scenario {scenario.name}")
    else:
        print(f"{design.name} on {scenario.name}")
        show_usable(found.numbers())
    if found is not None and plot is not None:
        from hfc_design.pictures.files import save
        from hfc_design.report.batch_plots import distributions

        save(distributions(found, f"{design.name} on {scenario.name}"), plot)
        if not as_json:
            print(plot)
    if not (as_json or isinstance(found, Robustness)):
        show_table(scenario, {design.name: evaluate(design, scenario)})


def _numbers(design: Design, scenario: Scenario, found: Evaluation) -> Json:
    """What there is to know before a number is believed, and the numbers."""
    lost = found.divergence and found.divergence._asdict()
    known = {"design": design.name, "scenario": scenario.name, "diverged": found.diverged}
    known |= {"chaotic": found.chaotic, "substeps": found.substeps, "divergence": lost}
    return known | found.score(scenario.judge())


def _robustness(
    design: Design, scenario: Scenario, spread: float, samples: int, seed: int
) -> Robustness:
    """One motion on many machines."""

    def progress(done: int, total: int) -> None:
        bar.show(description="simulating", completed=done, total=total)

    begun = time.monotonic()
    with ProgressBar("compiling", samples + 1, "machines") as bar:
        found = robustness(design, scenario, spread, samples, seed, progress)
    print(f"{samples} machines in {time.monotonic() - begun:.1f} s", file=sys.stderr)
    return found


def _tell_spread(design: Design, scenario: Scenario, found: Robustness, as_json: bool) -> None:
    names = {"design": design.name, "scenario": scenario.name, "judged_by": scenario.judge().title}
    numbers = names | found.numbers()
    if as_json:
        print(json.dumps(numbers))
    else:
        print(f"{QUESTION} {_answer(found)}")
        if missed := _missed(scenario, found):
            print(missed)
        _show_spread(found, numbers)
    if not found.usable:
        print(WARNING, file=sys.stderr)


def show_table(scenario: Scenario, rows: dict[str, Evaluation], caption: str = "") -> None:
    """Fitness, merit and metrics of some designs side by side, one column a design."""
    table = Table(caption=caption or None, caption_justify="left")
    table.add_column("metric", no_wrap=True)
    for name in rows:
        head = fill(name, 12, break_long_words=False, break_on_hyphens=False)
        table.add_column(head, justify="right")
    found = [*rows.values()]
    titles = len(scenario.judge().titles)
    shown = score_rows(scenario.judge(), found, ".5g", "-")
    if scenario.motions:  # of each the first one says most; the others are in --json and the report
        shown = shown[:titles] + motion_rows(found, ".4g", "-")
    for name, *values in shown:
        table.add_row(name.replace(" / ", "\n/ "), *values)
    show_whole(table)
    for note in notes(scenario, rows):
        print(fill(note, room()))


def show_usable(found: Json | None) -> None:
    """The answer first, then its figures (``Usable.numbers``); of no, a warning on stderr too."""
    if found is None:
        print(f"{QUESTION} that cannot be said: there is no machine within the tolerances")
        return
    _say(f"{QUESTION} {found['answer']}")
    if missed := in_use.missed_told(found.get("missed", {}), len(found["motions"])):
        _say(missed)
    if own := found.get("why_not"):
        print(f"{in_use.WHY}:")
        _show(in_use.why_table(own))
    if not found["usable"]:
        print(ONLY if found.get("verdict") == in_use.ON_THIS_MODEL else WARNING, file=sys.stderr)
    _show_motions(found)
    if stress := found.get("stress"):
        _show(in_use.stress_table(stress))
    _say(*_below(found))


def _show_motions(found: Json) -> None:
    """A row for each motion: share that passes, tracking, chatter, peak command, at its limit."""
    tracking, chatter, peak = found["units"]
    scale, unit = 1.0, found["units"][tracking]
    if unit == "rad":
        scale, unit = 1e6, "urad"
    command = found["units"][chatter]
    first, _, second = in_use.TITLES[tracking].partition(" ")  # over two columns
    heads = ["motion", "pass\n[%]", f"{first}\nmedian\n[{unit}]", f"{second}\n95 %\n[{unit}]"]
    for what in ("chatter", "peak"):
        heads += [f"| {what}\nmedian\n[{command}]", f"\nlargest\n[{command}]"]
    columns = [(scale, tracking, "median"), (scale, tracking, "q95")]
    columns += [(1.0, key, which) for key in (chatter, peak) for which in ("median", "largest")]
    columns.append((100.0, "limit_share", "largest"))
    rows = []
    for name, one in found["motions"].items():
        mark = " *" if one.get("asked_of") == "nominal" else ""
        values = [(factor, one["measures"][key][which]) for factor, key, which in columns]
        cells = [(100.0, one["share"]), *values]
        numbers = (in_use.measured(x, factor, three_digits, "-") for factor, x in cells)
        rows.append([name + mark, *numbers])
    show_rows([*heads, "| at limit\nlargest\n[% time]"], rows)


def _show(table: in_use.Told) -> None:
    if table.rows:
        show_rows(table.heads, table.rows)
    _say(*filter(None, (*table.lines, table.about)))


def _say(*lines: str) -> None:
    for line in lines:
        print(fill(line, room()))


def settling_told(found: Json | None, asked: Collection[str]) -> str:
    """What a scenario that has ``asked`` for these constraints may ask for, "" for nothing."""
    unsettled = found is not None and not found["usable"] and "oscillate" in found["answer"]
    if not unsettled or "unsettled" in asked:
        return ""
    return "The search did not require the loop to settle. Add --set constraints.unsettled=0.3"


def again_told(found: Json | None, seed: int) -> str:
    """What another search may try, "" where none helps: of stress the table says what does."""
    helps = found and not found["usable"] and found.get("verdict") != in_use.ON_THIS_MODEL
    more = f"--seed {seed}, twice the --generations, or a smaller robust.spread"
    return f"To get a usable design, try {more}" if helps else ""


def _below(found: Json) -> Iterator[str]:
    """What stands below the table, a line each."""
    low, high = found["interval"]
    yield (
        f"{100 * found['share']:.4g} % ({100 * low:.4g} to {100 * high:.4g} % with 95 % "
        "confidence) pass: stable, all constraints met"
    )
    yield from ABOUT
    gain = found["gain"]
    passes = gain and f"the nominal machine still passes {in_use.gain_told(gain)}"
    yield f"gain margin: {passes or 'none, the nominal machine does not pass'}"
    if worst := (found.get("margins") or {}).get("worst"):
        sizes = {
            name: "without end" if one["value"] is None else three_digits(one["value"])
            for name, one in worst.items()
        }
        each = ", ".join(f"{name} {size} ({worst[name]['at']})" for name, size in sizes.items())
        yield f"margins of the nominal loop: {each}; hfc stability tells all"
    if found["precision"] is not None:
        changes = f"numerics: merit changes by {percent(found['precision'])} in float64"
        if found["substeps"] is not None:
            changes += f", {percent(found['substeps'])} with finer time steps"
        yield changes
    if chaos := in_use.merit_told(found):
        yield chaos
    if any(one.get("asked_of") == "nominal" for one in found["motions"].values()):
        yield "* required on the nominal machine only"


def _answer(found: Robustness) -> str:
    """The same line for one motion on the machines of ``--spread``."""
    share, (low, high) = float(found.stable.mean()), found.interval
    machines = f"of {len(found.stable)} machines within +-{100 * found.spread:g} %"
    if not (found.usable or share):
        return f"no: not one {machines} is stable"
    stable = f"{100 * share:.4g} % {machines} are stable ({100 * low:.3g} to {100 * high:.3g} %)"
    if found.usable:
        return f"yes: {stable}"
    return f"no: {'' if found.nominal_stable else 'the nominal machine is not stable; '}{stable}"


def _missed(scenario: Scenario, found: Robustness) -> str:
    """How far the median machine is beyond the scenario's own tolerances, a line; "": it is not.

    The fitness of such a scenario is one over the weighted mean of measure / tolerance.
    """
    values = found.values["fitness"][found.stable]
    asked = isinstance(scenario.fitness, TolerancesSettings)
    if not (asked and len(values) and np.median(values) < 1.0):
        return ""
    return f"targets missed, value divided by target: {1.0 / np.median(values):.3g} on average"


def _show_spread(found: Robustness, numbers: Json) -> None:
    """Quantiles of each metric over the machines; ``numbers`` name design and scenario too."""
    chaotic = [key for key in found.ranges if key in numbers["metrics"]]
    lost = f"of the others {reasons_told(found.reasons)}\n" if found.reasons else ""
    heads = ("metric", "nominal", "5 %", "25 %", "50 %", "75 %", "95 %", "count")
    rows = []
    for key, values in numbers["metrics"].items():
        nominal, *quantiles = ("-" if x is None else three_digits(x) for x in values.values())
        rows.append([key, "chaotic" if key in chaotic else nominal, *quantiles])
    show_rows(
        heads,
        rows,
        title=f"{numbers['design']} on {numbers['scenario']}, "
        f"parameters +-{100 * numbers['spread']:g} %",
        title_style="",
        caption=f"{100 * numbers['stable_share']:.4g} % of {numbers['samples']} machines are "
        f"stable, the nominal one {'too' if numbers['nominal_stable'] else 'is not'}\n"
        f"{lost}quantiles of the stable ones that have the metric; merit is "
        f"{numbers['judged_by']}\n"
        f"{_refused(numbers['refused_draws'])}"
        f"simulated again with shorter steps: {numbers['refined']}"
        + "".join(f"\nnominal {chaos_told(key, found.ranges[key])}" for key in chaotic),
        caption_justify="left",
    )


def _refused(draws: int) -> str:
    """What became of machines that were drawn and cannot be, a line; "" without any."""
    line = f"{draws} more were drawn and replaced: no machine has such parameters together\n"
    return line if draws else ""
