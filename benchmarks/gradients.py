"""Lanes that carry a derivative beside plain ones, in one run.

    python benchmarks/gradients.py [--lanes 96] [--repeats 9] [--json FILE]

Table I of Lin & Lee 1999 on the ramp, 1 s in float32: the tracking error with its derivatives by so
many numbers of the controller, as the Gauss-Newton steps of a search need them, and the scores of
as many individuals. Both take their turns one after the other.
"""

import json
from functools import partial
from pathlib import Path

import click
import jax
import numpy as np
import report
from rich.console import Console
from rich.table import Table

from hfc_design.files.loop_setup import controller_of, load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop

SAMPLES = 1000


@click.command()
@click.option("--lanes", default=96, type=click.IntRange(1, 204), help="Derivatives at once.")
@click.option("--repeats", default=9, type=click.IntRange(1), help="Turns of both.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the numbers there.")
def main(lanes: int, repeats: int, target: Path | None) -> None:
    """Time derivatives beside scores, turn by turn."""
    console = Console(width=100)
    console.print(report.machine_table(facts := report.machine()))
    changes = [f"simulation.duration_s={SAMPLES / 1000}", "search.stick_penalty=0"]
    scenario = load_scenario("c-axis-ramp", changes)
    controller, one = controller_of(load_design("lin-lee-1999-table-1"), scenario)
    loop, samples = closed_loop(scenario, controller), scenario.samples()
    machines, chosen = simulate.one_machine(scenario.plant.values()), np.arange(lanes)
    many = jax.tree.map(lambda leaf: np.repeat(leaf, lanes, axis=-1), one)
    works = {
        "scores": partial(simulate.scores, loop, machines, [samples], many),
        "derivatives": partial(
            simulate.jacobians, loop.smooth, machines, samples, one, ("error",), chosen=chosen
        ),
    }
    compiling = {name: report.seconds(run) for name, run in works.items()}
    turns = np.array([[report.seconds(run) for run in works.values()] for _ in range(repeats)])
    table = Table("lanes of", "lane-steps/s", "scores / it", "compile, s")
    rows = {}
    for name, seconds in zip(works, turns.T, strict=True):
        speed = lanes * SAMPLES / float(np.median(seconds))
        ratio = float(np.median(seconds / turns[:, 0]))
        rows[name] = {"lane_steps_per_s": speed, "ratio": ratio, "compile_s": compiling[name]}
        table.add_row(name, f"{speed:.2e}", f"{ratio:.2f}", f"{compiling[name]:.1f}")
    console.print(table)
    if target:
        found = {"machine": facts, "lanes": lanes, "works": rows}
        target.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
