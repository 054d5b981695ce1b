"""Output of ``hfc design`` and ``hfc score`` on a design: its usability, then its metrics."""

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
from hfc_design.simulation import acceptance
from hfc_design.simulation.acceptance import Usable
from hfc_design.simulation.evaluating import Evaluation, evaluate, motion_rows, notes, score_rows
from hfc_design.simulation.monte_carlo import Robustness, check_draw, robustness
from hfc_design.simulation.repeats import chaos_text
from hfc_design.simulation.stability_criteria import reasons_text
from hfc_design.simulation.usable import SPREAD, usable
from hfc_design.stability.report import SAID

QUESTION = "Can I use it?"
WARNING = "hfc: warning: the design is not usable as it is"
ONLY = "hfc: warning: the design is usable only if the machine is as in the model"
#: Lines below the table of motions.
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
    """``hfc score`` on one scenario: usability, if there is a spread, then the metrics.

    Raises:
        UserError: a value is not allowed, or design and scenario do not fit.
    """
    judged: Usable | Robustness | None = None
    if scenario.robust or (scenario.motions and spread is not None):
        draw = (1 if samples is None else samples, 0 if seed is None else seed)
        check_draw(SPREAD if spread is None else spread, *draw)
        with busy("on unseen machines"):
            judged = usable(design, scenario, spread, samples, seed)
    elif spread is not None:
        draw = (1000 if samples is None else samples, 0 if seed is None else seed)
        judged = _robustness(design, scenario, spread, *draw)
    if isinstance(judged, Robustness):
        _tell_spread(design, scenario, judged, as_json)
    elif as_json:
        numbers = _numbers(design, scenario, evaluate(design, scenario))
        print(json.dumps(numbers | ({"can_i_use_it": judged.numbers()} if judged else {})))
    elif judged is None:
        print(f"scenario {scenario.name}")
    else:
        print(f"{design.name} on {scenario.name}")
        show_usable(judged.numbers())
    if judged is not None and plot is not None:
        from hfc_design.plotting.files import save
        from hfc_design.report.batch_plots import distributions

        save(distributions(judged, f"{design.name} on {scenario.name}"), plot)
        if not as_json:
            print(plot)
    if not (as_json or isinstance(judged, Robustness)):
        show_table(scenario, {design.name: evaluate(design, scenario)})


def _numbers(design: Design, scenario: Scenario, evaluation: Evaluation) -> Json:
    """Notes that limit the validity of the numbers, and the numbers."""
    lost = evaluation.divergence and evaluation.divergence._asdict()
    known = {"design": design.name, "scenario": scenario.name, "diverged": evaluation.diverged}
    known |= {"chaotic": evaluation.chaotic, "substeps": evaluation.substeps, "divergence": lost}
    return known | evaluation.score(scenario.judge())


def _robustness(
    design: Design, scenario: Scenario, spread: float, samples: int, seed: int
) -> Robustness:
    """Robustness of one motion over several machines."""

    def progress(done: int, total: int) -> None:
        bar.show(description="simulating", completed=done, total=total)

    begun = time.monotonic()
    with ProgressBar("compiling", samples + 1, "machines") as bar:
        result = robustness(design, scenario, spread, samples, seed, progress)
    print(f"{samples} machines in {time.monotonic() - begun:.1f} s", file=sys.stderr)
    return result


def _tell_spread(design: Design, scenario: Scenario, result: Robustness, as_json: bool) -> None:
    names = {"design": design.name, "scenario": scenario.name, "judged_by": scenario.judge().title}
    numbers = names | result.numbers()
    if as_json:
        print(json.dumps(numbers))
    else:
        print(f"{QUESTION} {_answer(result)}")
        if missed := _missed(scenario, result):
            print(missed)
        _show_spread(result, numbers)
    if not result.usable:
        print(WARNING, file=sys.stderr)


def show_table(scenario: Scenario, rows: dict[str, Evaluation], caption: str = "") -> None:
    """Print fitness, merit and metrics of some designs side by side, one column for each design."""
    table = Table(caption=caption or None, caption_justify="left")
    table.add_column("metric", no_wrap=True)
    for name in rows:
        head = fill(name, 12, break_long_words=False, break_on_hyphens=False)
        table.add_column(head, justify="right")
    evaluations = [*rows.values()]
    titles = len(scenario.judge().titles)
    shown = score_rows(scenario.judge(), evaluations, ".5g", "-")
    if scenario.motions:  # of each the first one says most; the others are in --json and the report
        shown = shown[:titles] + motion_rows(evaluations, ".4g", "-")
    for name, *values in shown:
        table.add_row(name.replace(" / ", "\n/ "), *values)
    show_whole(table)
    for note in notes(scenario, rows):
        print(fill(note, room()))


def show_usable(numbers: Json | None) -> None:
    """Print the verdict, then its numbers (``Usable.numbers``); a "no" also warns on stderr."""
    if numbers is None:
        print(f"{QUESTION} Unknown: there is no machine within the tolerances")
        return
    _say(f"{QUESTION} {numbers['answer']}")
    if missed := acceptance.missed_text(numbers.get("missed", {}), len(numbers["motions"])):
        _say(missed)
    if analysis := numbers.get("why_not"):
        print(f"{acceptance.WHY}:")
        _show(acceptance.why_table(analysis))
    if not numbers["usable"]:
        print(
            ONLY if numbers.get("verdict") == acceptance.ON_THIS_MODEL else WARNING, file=sys.stderr
        )
    _show_motions(numbers)
    if stress := numbers.get("stress"):
        _show(acceptance.stress_table(stress))
    _say(*_below(numbers))


def _show_motions(usable: Json) -> None:
    """A row for each motion: share that passes, tracking, chatter, peak command, share at limit."""
    tracking, chatter, peak = usable["units"]
    scale, unit = 1.0, usable["units"][tracking]
    if unit == "rad":
        scale, unit = 1e6, "urad"
    command = usable["units"][chatter]
    first, _, second = acceptance.TITLES[tracking].partition(" ")  # over two columns
    heads = ["motion", "pass\n[%]", f"{first}\nmedian\n[{unit}]", f"{second}\n95 %\n[{unit}]"]
    for what in ("chatter", "peak"):
        heads += [f"| {what}\nmedian\n[{command}]", f"\nlargest\n[{command}]"]
    columns = [(scale, tracking, "median"), (scale, tracking, "q95")]
    columns += [(1.0, key, which) for key in (chatter, peak) for which in ("median", "largest")]
    columns.append((100.0, "limit_share", "largest"))
    rows = []
    for name, one in usable["motions"].items():
        mark = " *" if one.get("asked_of") == "nominal" else ""
        values = [(factor, one["measures"][key][which]) for factor, key, which in columns]
        cells = [(100.0, one["share"]), *values]
        numbers = (acceptance.measured(x, factor, three_digits, "-") for factor, x in cells)
        rows.append([name + mark, *numbers])
    show_rows([*heads, "| at limit\nlargest\n[% time]"], rows)


def _show(table: acceptance.TextTable) -> None:
    if table.rows:
        show_rows(table.heads, table.rows)
    _say(*filter(None, (*table.lines, table.about)))


def _say(*lines: str) -> None:
    for line in lines:
        print(fill(line, room()))


def settling_told(numbers: Json | None, constraints: Collection[str]) -> str:
    """Advice on a requirement to add to a scenario with these ``constraints``; "" if none."""
    unsettled = numbers is not None and not numbers["usable"] and "oscillate" in numbers["answer"]
    if not unsettled or "unsettled" in constraints:
        return ""
    return "The search did not require the loop to settle. Add --set constraints.unsettled=0.3"


def again_told(numbers: Json | None, seed: int) -> str:
    """Advice for another search; "" if none helps, since the table has the advice on stress."""
    helps = numbers and not numbers["usable"] and numbers.get("verdict") != acceptance.ON_THIS_MODEL
    more = f"--seed {seed}, twice the --generations, or a smaller robust.spread"
    return f"To get a usable design, try {more}" if helps else ""


def _below(numbers: Json) -> Iterator[str]:
    """Lines below the table."""
    low, high = numbers["interval"]
    limited = any(one.get("constraints") for one in numbers["motions"].values())
    met = ", all constraints met" if limited else "; there are no constraints to meet"
    yield (
        f"{100 * numbers['share']:.4g} % ({100 * low:.4g} to {100 * high:.4g} % with 95 % "
        f"confidence) pass: stable{met}"
    )
    yield from ABOUT
    gain = numbers["gain"]
    passes = gain and f"the nominal machine still passes {acceptance.gain_text(gain)}"
    yield f"command scaling: {passes or 'none, the nominal machine does not pass'}"
    if worst := (numbers.get("margins") or {}).get("worst"):
        sizes = {
            name: "without limit" if one["value"] is None else three_digits(one["value"])
            for name, one in worst.items()
        }
        each = ", ".join(
            f"{SAID[name].format(size)} ({worst[name]['at']})" for name, size in sizes.items()
        )
        yield f"margins of the nominal loop: {each}; hfc stability lists all"
    if numbers["precision"] is not None:
        changes = f"numerics: merit changes by {percent(numbers['precision'])} in float64"
        if numbers["substeps"] is not None:
            changes += f", {percent(numbers['substeps'])} with finer time steps"
        yield changes
        if advice := acceptance.numerics_text(numbers):
            yield advice
    if chaos := acceptance.merit_text(numbers):
        yield chaos
    if any(one.get("asked_of") == "nominal" for one in numbers["motions"].values()):
        yield "* required on the nominal machine only"


def _answer(result: Robustness) -> str:
    """The verdict line for one motion on the machines of ``--spread``."""
    share, (low, high) = float(result.stable.mean()), result.interval
    machines = f"of {len(result.stable)} machines within +-{100 * result.spread:g} %"
    if not (result.usable or share):
        return f"no: not one {machines} is stable"
    stable = f"{100 * share:.4g} % {machines} are stable ({100 * low:.3g} to {100 * high:.3g} %)"
    if result.usable:
        return f"yes: {stable}"
    return f"no: {'' if result.nominal_stable else 'the nominal machine is not stable; '}{stable}"


def _missed(scenario: Scenario, result: Robustness) -> str:
    """Line if the median machine misses the scenario's own targets; "" otherwise.

    The fitness of such a scenario is one over the weighted mean of measure / target.
    """
    values = result.values["fitness"][result.stable]
    has_targets = isinstance(scenario.fitness, TolerancesSettings)
    if not (has_targets and len(values) and np.median(values) < 1.0):
        return ""
    return f"targets missed, value divided by target: {1.0 / np.median(values):.3g} on average"


def _show_spread(result: Robustness, numbers: Json) -> None:
    """Quantiles of each metric over the machines; ``numbers`` contain design and scenario too."""
    chaotic = [key for key in result.ranges if key in numbers["metrics"]]
    lost = f"of the others {reasons_text(result.reasons)}\n" if result.reasons else ""
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
        + "".join(f"\nnominal {chaos_text(key, result.ranges[key])}" for key in chaotic),
        caption_justify="left",
    )


def _refused(draws: int) -> str:
    """Line on drawn machines that are impossible; "" without any."""
    line = f"{draws} draws were replaced, as their parameters are impossible together\n"
    return line if draws else ""
