"""What ``hfc score --spread`` shows: one design on machines whose parameters are spread."""

import json
import sys
import time

import numpy as np

from hfc_design.cli.usable_table import QUESTION, WARNING
from hfc_design.core.console import ProgressBar, show_rows
from hfc_design.core.numbers import Json
from hfc_design.core.wording import three_digits
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.tolerances import TolerancesSettings
from hfc_design.simulation.monte_carlo import Robustness, robustness
from hfc_design.simulation.repeats import chaos_told
from hfc_design.simulation.settling import reasons_told


def score_spread(
    design: Design,
    scenario: Scenario,
    spread: float,
    as_json: bool,
    samples: int = 1000,
    seed: int = 0,
) -> Robustness:
    """``hfc score --spread``: one design on many machines.

    Raises:
        UserError: a value is not allowed, or design and scenario do not fit.
    """

    def progress(done: int, total: int) -> None:
        bar.show(description="simulating", completed=done, total=total)

    begun = time.monotonic()
    with ProgressBar("compiling", samples + 1, "machines") as bar:
        found = robustness(design, scenario, spread, samples, seed, progress)
    print(f"{samples} machines in {time.monotonic() - begun:.1f} s", file=sys.stderr)
    own = {"design": design.name, "scenario": scenario.name, "judged_by": scenario.judge().title}
    numbers = own | found.numbers()
    if as_json:
        print(json.dumps(numbers))
    else:
        print(f"{QUESTION} {_answer(found)}")
        if missed := _missed(scenario, found):
            print(missed)
        _show(found, numbers)
    if not found.usable:
        print(WARNING, file=sys.stderr)
    return found


def _answer(found: Robustness) -> str:
    """The same line for one motion on the machines of ``--spread``."""
    share, (low, high) = float(found.stable.mean()), found.interval
    machines = f"of {len(found.stable)} machines within +-{100 * found.spread:g} %"
    if not (found.usable or share):
        return f"no: not one {machines} is stable"
    told = f"{100 * share:.4g} % {machines} are stable ({100 * low:.3g} to {100 * high:.3g} %)"
    if found.usable:
        return f"yes: {told}"
    return f"no: {told if found.nominal_stable else f'the nominal machine is not stable; {told}'}"


def _missed(scenario: Scenario, found: Robustness) -> str:
    """How far the median machine is beyond the scenario's own tolerances, a line; "": it is not.

    The fitness of such a scenario is one over the weighted mean of measure / tolerance.
    """
    values = found.values["fitness"][found.stable]
    asked = isinstance(scenario.fitness, TolerancesSettings)
    if not (asked and len(values) and np.median(values) < 1.0):
        return ""
    return f"targets missed, value divided by target: {1.0 / np.median(values):.3g} on average"


def _show(found: Robustness, numbers: Json) -> None:
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
    told = f"{draws} more were drawn and replaced: no machine has such parameters together\n"
    return told if draws else ""
