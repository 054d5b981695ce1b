"""Output of ``hfc design`` and ``hfc score`` on a design: its usability, then its metrics."""

import json
import sys
import time
from collections.abc import Collection, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from hfc_design.core.console import MachinesBar, busy, say, show
from hfc_design.core.numbers import Json
from hfc_design.core.wording import percent, three_digits
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.tolerances import TolerancesSettings
from hfc_design.simulation import acceptance, usable_tables
from hfc_design.simulation.acceptance import Usable
from hfc_design.simulation.evaluating import Evaluation, evaluate, score_table
from hfc_design.simulation.monte_carlo import Robustness, check_draw, robustness
from hfc_design.simulation.usable import SPREAD, usable
from hfc_design.stability.margins import ASKED, GOALS
from hfc_design.stability.report import SAID

QUESTION = "Can I use it?"
WARNING = "hfc: warning: the design is not usable as it is"
#: A margin that has reached this share of its limit may be what keeps a loop slow.
NEAR = 0.9
ONLY = "hfc: warning: the design is usable only if the machine is as in the model"


def score_one(
    design: Design,
    scenario: Scenario,
    spread: float | None,
    as_json: bool,
    plot: Path | None = None,
    samples: int | None = None,
    seed: int | None = None,
) -> None:
    """Print the output of ``hfc score`` on one scenario: usability, if required, and metrics.

    Raises:
        UserError: a value is not allowed, or design and scenario do not fit.
    """
    judged: Usable | Robustness | None = None
    required = scenario.motions or scenario.constraints
    if scenario.robust or (required and spread is not None):
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
        show(score_table(scenario, {design.name: evaluate(design, scenario)}))


def _numbers(design: Design, scenario: Scenario, evaluation: Evaluation) -> Json:
    """Return what --json prints: notes on the validity (diverged, chaotic), and the metrics."""
    lost = evaluation.divergence and evaluation.divergence._asdict()
    known = {"design": design.name, "scenario": scenario.name, "diverged": evaluation.diverged}
    known |= {"chaotic": evaluation.chaotic, "substeps": evaluation.substeps, "divergence": lost}
    return known | evaluation.score(scenario.judge())


def _robustness(
    design: Design, scenario: Scenario, spread: float, samples: int, seed: int
) -> Robustness:
    """Return the robustness of one motion over ``samples`` machines, and show the progress."""
    begun = time.monotonic()
    with MachinesBar() as bar:
        progress = partial(bar.chunk, "simulating")
        result = robustness(design, scenario, spread, samples, seed, progress)
    print(f"{samples} machines in {time.monotonic() - begun:.1f} s", file=sys.stderr)
    return result


def _tell_spread(design: Design, scenario: Scenario, result: Robustness, as_json: bool) -> None:
    if as_json:
        names = {"design": design.name, "scenario": scenario.name}
        judged = {"judged_by": scenario.judge().title}
        print(json.dumps(names | judged | result.numbers()))
    else:
        print(f"{design.name} on {scenario.name}")
        say(f"{QUESTION} {_answer(result)}")
        if missed := _missed(scenario, result):
            say(missed)
        show(*result.tables())
    if not result.usable:
        print(WARNING, file=sys.stderr)


def show_usable(numbers: Json | None) -> None:
    """Print the verdict and its numbers (``Usable.numbers``); if it is not yes, warn on stderr."""
    if numbers is None:
        print(f"{QUESTION} Unknown: there is no machine within the tolerances")
        return
    say(f"{QUESTION} {numbers['answer']}")
    if missed := acceptance.missed_text(numbers.get("missed", {}), len(numbers["motions"])):
        say(missed)
    if numbers.get("why_not"):
        print(f"{usable_tables.WHY}:")
    show(*usable_tables.tables(numbers))
    if not numbers["usable"]:
        print(
            ONLY if numbers.get("verdict") == acceptance.ON_THIS_MODEL else WARNING, file=sys.stderr
        )
    say(*_below(numbers))


def settling_told(numbers: Json | None, constraints: Collection[str]) -> str:
    """Return the advice to require that the loop settles, if it oscillates; "" if not needed."""
    unsettled = numbers is not None and not numbers["usable"] and "oscillate" in numbers["answer"]
    if not unsettled or "unsettled" in constraints:
        return ""
    return "The search did not require the loop to settle. Add --set constraints.unsettled=0.3"


def again_told(numbers: Json | None, scenario: Scenario) -> str:
    """Return advice for another search; "" if usable, or if only stress fails (see its table)."""
    if not numbers or numbers["usable"] or numbers.get("verdict") == acceptance.ON_THIS_MODEL:
        return ""
    more = [f"--seed {scenario.run.seed + 1}", "twice the --generations", "a smaller robust.spread"]
    if scenario.controller.kind != "pid+ff":
        more.append("--controller pid+ff")
    more += _at_its_limit(numbers, scenario)
    return f"To get a usable design, try {', '.join(more[:-1])} or {more[-1]}"


def _at_its_limit(numbers: Json, scenario: Scenario) -> Iterator[str]:
    """Yield advice to loosen margins that the loop just has or lacks, since they keep it slow."""
    worst = (numbers.get("margins") or {}).get("worst") or {}
    for key, limit in scenario.margins.items():
        name, larger_is_worse, _ = ASKED[key]
        value = worst.get(name, {}).get("value")
        if value and (value / limit if larger_is_worse else limit / value) > NEAR:
            yield f"a looser constraints.{key} ({value:.3g} {worst[name]['at']}, allowed {limit:g})"


def _below(numbers: Json) -> Iterator[str]:
    """Yield the lines below the table."""
    low, high = numbers["interval"]
    limited = any(one.get("constraints") for one in numbers["motions"].values())
    met = ", all constraints met" if limited else "; there are no constraints to meet"
    yield (
        f"{100 * numbers['share']:.4g} % ({100 * low:.4g} to {100 * high:.4g} % with 95 % "
        f"confidence) pass: stable{met}"
    )
    gain = numbers["gain"]
    passes = gain and f"the nominal machine still passes {acceptance.gain_text(gain)}"
    yield f"command scaling: {passes or 'none, the nominal machine does not pass'}"
    if worst := (numbers.get("margins") or {}).get("worst"):
        sizes = {
            name: "without limit" if one["value"] is None else three_digits(one["value"])
            for name, one in worst.items()
            if name not in GOALS
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
    """Return the verdict for one motion on the machines of ``--spread``, as a line."""
    share, (low, high) = float(result.stable.mean()), result.interval
    machines = f"of {len(result.stable)} machines within +-{100 * result.spread:g} %"
    if not (result.usable or share):
        return f"no: not one {machines} is stable"
    stable = f"{100 * share:.4g} % {machines} are stable ({100 * low:.3g} to {100 * high:.3g} %)"
    if result.usable:
        return f"yes: {stable}"
    return f"no: {'' if result.nominal_stable else 'the nominal machine is not stable; '}{stable}"


def _missed(scenario: Scenario, result: Robustness) -> str:
    """Return the line that the median machine misses the targets of the scenario; "" otherwise.

    The fitness of such a scenario is 1 / (weighted mean of value / target).
    """
    values = result.values["fitness"][result.stable]
    has_targets = isinstance(scenario.fitness, TolerancesSettings)
    if not (has_targets and len(values) and np.median(values) < 1.0):
        return ""
    return f"targets missed, value divided by target: {1.0 / np.median(values):.3g} on average"
