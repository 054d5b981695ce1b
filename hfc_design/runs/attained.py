"""How near designs come to what any controller could do: sums of |e| beside their bounds."""

import json
from pathlib import Path

import numpy as np

from hfc_design.attainable.attainable import Attainable, attainable
from hfc_design.core import checkpoint
from hfc_design.core.numbers import Json
from hfc_design.files.design import AnyDesign
from hfc_design.files.pairing import load_design, machine, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.runs.beside import AttainableFile, beside
from hfc_design.simulation.evaluating import Evaluation, evaluate

#: In a run folder: what ``attained`` gives.
ATTAINABLE = "attainable.json"


def attained(scenario: Scenario, design: AnyDesign | None = None) -> Json:
    """Bound and best known voltage of every motion, and what a ``design`` does, as plain data.

    Of a design the machine is its own with what the scenario sets laid over it.

    Raises:
        UserError: the scenario has no bound, or the design does not fit.
        RunError: the solver of linear programmes found nothing.
    """
    if design is None:
        return _left_out(scenario) | _numbers(attainable(scenario), None)
    design = load_design(design)
    scenario = with_converter(scenario, design)
    scenario = scenario.model_copy(update={"plant": machine(design, scenario)})
    return _left_out(scenario) | _numbers(attainable(scenario), evaluate(design, scenario))


def _left_out(scenario: Scenario) -> Json:
    """What neither bound nor best voltage knows of; nothing where there is no such limit."""
    slow = any(scenario.limits.of(x).command_rate for x in scenario.plant.machine.axes)
    return {"left_out": "limits.command_rate"} if slow else {}


def _numbers(found: dict[str, Attainable], evaluation: Evaluation | None) -> Json:
    motions = {name: one.numbers() for name, one in found.items()}
    if evaluation is not None:
        each = [*evaluation.motions.values()] or [evaluation]
        for one, motion in zip(each, motions.values(), strict=True):
            total = float(np.abs(one.axes[0].motion.error).sum())
            lost = one.diverged or not np.isfinite(total)
            motion["sum_error"] = None if lost else total
    return {"unit": "rad", "motions": motions}


def keep_attained(scenario: Scenario, design: AnyDesign, folder: Path) -> Json:
    """``attained`` of the design of a run, which its folder keeps for its page.

    Raises:
        UserError: the scenario has no bound.
        RunError: the solver found nothing, or the folder cannot be written.
    """
    numbers = attained(scenario, design)
    checkpoint.write_whole(folder / ATTAINABLE, (json.dumps(numbers, indent=1) + "\n").encode())
    return numbers


def kept_attained(folder: Path) -> Json | None:
    """How near a run's design comes to its bound; None if nobody said. RunError: it is damaged."""
    return beside(folder / ATTAINABLE, AttainableFile)


#: Of ``attained_rows``.
HEADS = ("bound", "best voltage", "this design", "times bound", "times best")


def attained_rows(found: Json) -> list[list[str]]:
    """A row a motion: its name, then ``HEADS``; sums of |e| [rad]."""
    rows = []
    for name, one in found["motions"].items():
        bound, reached, own = one["bound"], one["reached"], one.get("sum_error")
        cells = [name, f"{bound:.4g}", f"{reached:.4g}"]
        numbers = [own, own and _times(own, bound), own and _times(own, reached)]
        rows.append([*cells, *("–" if x is None else f"{x:.4g}" for x in numbers)])
    return rows


def attained_told(found: Json) -> str:
    """The line of a design with one motion, "" of others."""
    (row, *others) = attained_rows(found)
    _, bound, reached, own, by_bound, by_reached = row
    if others or own == "–":
        return ""
    return (
        f"sum |e| {own} rad: {by_bound} times the certified bound {bound}, "
        f"{by_reached} times the best open-loop voltage {reached}{left_out(found)}"
    )


def left_out(found: Json) -> str:
    """What the numbers do not know of, to stand behind them; "" where that is nothing."""
    return f" ({found['left_out']} is left out)" if "left_out" in found else ""


def _times(own: float, other: float) -> float | None:
    return own / other if other > 0.0 else None
