"""Comparison of designs with the best attainable control: sums of |e| beside their bounds."""

import json
from pathlib import Path

import numpy as np

from hfc_design.attainable.attainable import attainable
from hfc_design.core import checkpoint
from hfc_design.core.numbers import Json
from hfc_design.core.tables import MISSING, Table
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import load_design, machine, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.runs.stored import AttainableFile, read_numbers
from hfc_design.simulation.evaluating import evaluate

#: File in a run folder with the result of ``attained``.
ATTAINABLE = "attainable.json"


def attained(scenario: Scenario, design: AnyDesign | None = None) -> Json:
    """Return bound and best known sum of |e| of every motion, and the sum of a ``design``, as JSON.

    With a design, the machine is that of the design, changed by the settings of the scenario.

    Raises:
        UserError: the scenario has no bound, or the design does not fit.
        RunError: the solver of linear programmes found no solution.
    """
    if design is not None:
        design = load_design(design)
        scenario = with_converter(scenario, design)
        scenario = scenario.model_copy(update={"plant": machine(design, scenario)})
    motions = {name: x.numbers() for name, x in attainable(scenario).items()}
    if design is not None:
        evaluation = evaluate(design, scenario)
        evaluations = [*evaluation.motions.values()] or [evaluation]
        for x, motion in zip(evaluations, motions.values(), strict=True):
            total = float(np.abs(x.axes[0].motion.error).sum())
            motion["sum_error"] = None if x.diverged or not np.isfinite(total) else total
    limits = scenario.limits.of(scenario.plant.machine.axes[0])
    # Limits that bound and best voltage do not consider.
    whole = ["delay_samples"] if limits.delay_samples.is_integer() else []
    left = ", ".join(limits.other_than("command", "resolution", *whole))
    return {**({"left_out": left} if left else {}), "unit": "rad", "motions": motions}


def keep_attained(scenario: Scenario, design: AnyDesign, folder: Path) -> Json:
    """Write the result of ``attained`` for a run's design to the run folder, and return it.

    Raises:
        UserError: the scenario has no bound.
        RunError: the solver found no solution, or the folder cannot be written.
    """
    numbers = attained(scenario, design)
    checkpoint.write_whole(folder / ATTAINABLE, (json.dumps(numbers, indent=1) + "\n").encode())
    return numbers


def kept_attained(folder: Path) -> Json | None:
    """Return the stored result of ``attained``; None if there is none. RunError: it is damaged."""
    return read_numbers(folder / ATTAINABLE, AttainableFile, attained_table)


#: Heads of the columns of ``attained_table``; the last ones are of a design.
HEAD = ("motion", "bound", "best voltage", "this design", "times bound", "times best")


def attained_table(numbers: Json) -> Table:
    """Return a table with the sums of |e| [rad] of each motion."""
    motions, rows = numbers["motions"], []
    for name, sums in motions.items():
        best, error = (sums["bound"], sums["reached"]), sums.get("sum_error")
        ratios = (None if error is None or x <= 0.0 else error / x for x in best)
        cells = (*best, error, *ratios)
        rows.append([name, *(MISSING if x is None else f"{x:.4g}" for x in cells)])
    shown = slice(None if any("sum_error" in one for one in motions.values()) else 3)
    about = (
        "Sum of the error's magnitude over all samples [rad], on the nominal machine with ideal "
        "sensors: no controller can be below the bound; the best voltage was found with full "
        f"knowledge of the motion{left_out(numbers)}."
    )
    return Table(about, HEAD[shown], [row[shown] for row in rows])


def attained_told(numbers: Json) -> str:
    """Return a line for a design in a single motion; "" for several motions, or without a sum."""
    ((_, bound, reached, *of_design), *others) = attained_table(numbers).rows
    if others or MISSING in of_design[:1] or not of_design:
        return ""
    error, by_bound, by_reached = of_design
    return (
        f"sum |e| {error} rad: {by_bound} times the certified bound {bound}, "
        f"{by_reached} times the best open-loop voltage {reached}{left_out(numbers)}"
    )


def left_out(numbers: Json) -> str:
    """Return a note on the effects that the numbers leave out; "" if there are none."""
    return f" (left out: {numbers['left_out']})" if "left_out" in numbers else ""
