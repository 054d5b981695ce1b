"""The evaluator with every kind of controller: 1,000 machines, in one run.

    python benchmarks/controllers.py [--machines 1000] [--repeats 5] [--json FILE]

The C-axis with its hierarchy comes first; the others are X-Y machines: two feed drives that run the
circle of Jee & Koren 2004, fig. 10, three times, and milling tables that run that of Huang & Shy
once; and a machine of five axes on the program of Lin & Gai 2009, 1 s. Each machine has gains of
its own.
"""

import json
import time
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import click
import jax
import numpy as np
import report
from designs import CROSS_COUPLED, NEURAL, design_of
from rich.console import Console
from rich.table import Table

from hfc_design.files.loop_setup import controller_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import compiled
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.population import Machines
from hfc_design.simulation.stepping import Inputs

#: Design -> the scenario that it runs.
DESIGNS = {
    "lin-lee-1999-table-1": "c-axis-ramp",
    "jee-koren-2004-pid": "feed-drive-circle",
    "jee-koren-2004-flc": "feed-drive-circle",
    "jee-koren-2004-aflc": "feed-drive-circle",
    "jee-koren-1995-soflc": "feed-drive-circle",
    "huang-pid": "milling-table-circle",
    "huang-soc": "milling-table-circle",
    NEURAL: "milling-table-circle",
    CROSS_COUPLED: "milling-table-circle",
    "lin-gai-2009-pid": "five-axis-program",
    "lin-gai-2009-fuzzy-sliding": "five-axis-program",
    "lin-gai-2009-fuzzy-sliding-compensated": "five-axis-program",
}
SPREAD = 0.02  # of every gain


class Work(NamedTuple):
    """What one kind of controller has to do, compiled."""

    run: Any  # () -> scores
    axis_steps: int  # control samples of single axes
    operations: float  # floating-point operations of one of them
    compile_s: float


def prepared(design: str, scenario: str, machines: int) -> Work:
    """A population around ``design``, scored once."""
    found = load_scenario(scenario, ["search.stick_penalty=0"])  # the fitness alone
    controller, one = controller_of(design_of(design), found)
    loop = closed_loop(found, controller)
    nominal, samples = simulate.one_machine(found.plant.values()), found.samples()
    generator = np.random.default_rng(0)

    def spread(leaf: np.ndarray) -> np.ndarray:
        many = np.repeat(leaf, machines, axis=-1)
        if leaf.dtype.kind == "i":
            return many
        return many * (1.0 + SPREAD * generator.uniform(-1.0, 1.0, many.shape))

    gains = jax.tree.map(spread, one)
    run = partial(simulate.scores, loop, nominal, [samples], gains)
    begun = time.perf_counter()
    run()
    compiling = time.perf_counter() - begun
    axes = len(loop.machine.axes)
    operations = _operations(loop, nominal, samples, one) / axes
    return Work(run, machines * axes * found.simulation.steps, operations, compiling)


def _operations(loop: Loop, machines: Machines, samples: Any, one: Any) -> float:
    """Floating-point operations of a sample of one machine, as the compiler counts them.

    It counts a loop's body once: of the drive's integration steps in a sample, only one.
    """
    lanes = compiled.CHUNK * jax.device_count()
    gains = jax.tree.map(lambda leaf: np.repeat(leaf, lanes, axis=-1), one)
    code, data = loop.apart
    inputs = Inputs(data, *machines.one, samples, gains)
    numbers = inputs.packed(False, np.float32, compiled.CHUNK)
    program = compiled.scores.lower(code, False, *numbers).compile()
    return program.cost_analysis()["flops"] / compiled.CHUNK  # of one device


@click.command()
@click.option("--machines", default=1000, type=click.IntRange(1), help="Machines at once.")
@click.option("--repeats", default=5, type=click.IntRange(1), help="Turns of every controller.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the numbers there.")
def main(machines: int, repeats: int, target: Path | None) -> None:
    """Time the evaluator with every kind of controller, turn by turn."""
    console = Console(width=115)  # the longest name in a line
    console.print(report.machine_table(facts := report.machine()))
    works = {name: prepared(name, scenario, machines) for name, scenario in DESIGNS.items()}
    turns = np.array(
        [[report.seconds(work.run) for work in works.values()] for _ in range(repeats)]
    )
    speeds = np.array([work.axis_steps for work in works.values()]) / turns
    table = Table("design", title=f"{machines} machines, float32, medians of {repeats} turns")
    for heading in ("time, s", "axis-steps/s", "C-axis / it", "operations a step", "compile, s"):
        table.add_column(heading, justify="right")
    rows = {}
    for k, (name, work) in enumerate(works.items()):
        rows[name] = {
            "time_s": float(np.median(turns[:, k])),
            "axis_steps_per_s": float(np.median(speeds[:, k])),
            "c_axis_ratio": float(np.median(speeds[:, 0] / speeds[:, k])),
            "operations": work.operations,
            "compile_s": work.compile_s,
        }
        formats = (".2f", ".2e", ".2f", ".0f", ".1f")
        values = zip(rows[name].values(), formats, strict=True)
        table.add_row(name, *(format(value, form) for value, form in values))
    console.print(table)
    if target:
        text = json.dumps({"machine": facts, "machines": machines, "controllers": rows}, indent=1)
        target.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
