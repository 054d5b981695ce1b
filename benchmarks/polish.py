"""The polish of `hfc design --polish` beside optimistix, from the same designs.

    python benchmarks/polish.py [--steps 40] [--seeds 3] [--seconds 1] [--json FILE]

Each design is the best of a short search (race, 200 individuals, 40 generations, 250 V). Then
Levenberg-Marquardt and Dogleg of optimistix and the project's own steps go on from it with as many
derivatives each, in float64: a step is one derivative. optimistix is given residuals whose squares
add up to ``sum sqrt(e^2 + floor^2)``, which is what the fitness falls with, in the coordinates of
the polish, with its floor in shares of the largest error; it looks at one individual a step.
"""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import jax
import jax.numpy as jnp
import numpy as np
import optimistix
import report
from rich.console import Console
from rich.table import Table

from hfc_design.controllers.genome import Population, taken
from hfc_design.core.numbers import Floats
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.runs.polishing import PolishTask
from hfc_design.runs.problem import Problem
from hfc_design.search import polish
from hfc_design.search.coordinates import chain, coordinates
from hfc_design.search.loop import generations, searcher
from hfc_design.simulation import population as simulate

jax.config.update("jax_cpu_enable_async_dispatch", False)
#: Solvers, each with how far magnitudes are smoothed for it, in shares of the largest error.
SOLVERS = {
    "LM": (optimistix.LevenbergMarquardt, (1e-4, 1e-3, 1e-2)),
    "Dogleg": (optimistix.Dogleg, (1e-3,)),
}
TASKS = ("c-axis-ramp", "c-axis-ramp-cutting")


def searched(name: str, seed: int, seconds: float) -> tuple[Scenario, Population]:
    """A scenario and the best that a short search finds there."""
    small = {"search.population": 200, "search.generations": 40, "limits.command": 250.0}
    scenario = load_scenario(name, {**small, "simulation.duration_s": seconds, "run.seed": seed})
    problem = Problem(scenario)
    parts = (searcher(scenario.search, problem.task), problem.genome, 40, seed)
    *_, last = generations(*parts, problem.scored)
    best = np.array([int(last.archive.score.argmax())])
    return scenario, taken(last.archive.population, best)


def polished(task: polish.Polishable, one: Population, steps: int, seed: int) -> float:
    """The worst double's merit after so many steps of the project's own."""
    *_, last = polish.polish(task, one, steps, seed)
    return float(last.worth.min())


class Residuals:
    """``(e^2 + floor^2)^(1/4)`` of the coordinates of an individual, for optimistix.

    It is the simulator of the polish that is called, and its derivative; both are counted.
    """

    def __init__(self, scenario: Scenario, one: Population, share: float):
        self.problem = Problem(scenario)
        found = coordinates(self.problem.genome, one)
        assert found is not None
        self.own, self.derivatives = found, 0
        largest = np.abs(self._errors(np.zeros(self.own.size))[0]).max()
        self.floor, self.steps = share * largest, scenario.simulation.steps

    def _errors(self, x: Floats) -> tuple[Floats, Floats]:
        """Errors (steps,) and their derivative by the numbers of the gains."""
        loop, machines, (samples,) = self.problem.loop, self.problem.machines, self.problem.motions
        gains = self.problem.genome.gains(self.own.members(np.asarray(x)[None]))
        about = (loop, machines, samples, gains)
        return simulate.jacobians(*about, ("error",), np.float64)["error"]

    def values(self, x: Floats) -> Floats:
        """(steps,) of a point."""
        loop, machines, (samples,) = self.problem.loop, self.problem.machines, self.problem.motions
        gains = self.problem.genome.gains(self.own.members(np.asarray(x)[None]))
        _, (motion,), _ = simulate.trajectories(loop, machines, [samples], gains)[0]
        return np.asarray((motion.error[:, 0] ** 2 + self.floor**2) ** 0.25)

    def linear(self, x: Floats) -> tuple[Floats, Floats]:
        """(steps,) and (steps, coordinates) of a point."""
        self.derivatives += 1
        error, jacobian = self._errors(x)
        square = error**2 + self.floor**2
        slope = 0.5 * error * square**-0.75
        follows = chain(self.problem.genome, self.own, np.asarray(x))
        return square**0.25, slope[:, None] * (jacobian @ follows)

    def function(self) -> Callable[..., Any]:
        """The same as JAX wants it."""
        size, steps = self.own.size, self.steps
        value = jax.ShapeDtypeStruct((steps,), np.float64)
        slope = jax.ShapeDtypeStruct((steps, size), np.float64)

        @jax.custom_jvp
        def residuals(x: Any) -> Any:
            return jax.pure_callback(self.values, value, x)

        @residuals.defjvp
        def _(primals: Any, tangents: Any) -> Any:
            found, jacobian = jax.pure_callback(self.linear, (value, slope), *primals)
            return found, jacobian @ tangents[0]

        return lambda x, arguments: residuals(x)


def by_optimistix(
    scenario: Scenario, task: polish.Polishable, one: Population, steps: int
) -> Iterator[tuple[str, float]]:
    """Each solver with each of its floors, and the merit that it ends with, never worse."""
    for name, (solver, shares) in SOLVERS.items():
        for share in shares:
            own = Residuals(scenario, one, share)
            found = optimistix.least_squares(
                own.function(),
                solver(rtol=1e-12, atol=1e-12),
                jnp.zeros(own.own.size),
                options={"jac": "fwd"},
                max_steps=steps,
                throw=False,
            )
            assert own.derivatives <= steps
            end = own.own.members(np.asarray(found.value)[None])
            worths = [float(task.worth(x).min()) for x in (one, end)]
            yield f"{name} {share:g}", max(worths)


@click.command()
@click.option("--steps", default=40, type=click.IntRange(1), help="Derivatives of each.")
@click.option("--seeds", default=3, type=click.IntRange(1), help="Designs of each task.")
@click.option("--seconds", default=1.0, help="Of the motion.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the numbers there.")
def main(steps: int, seeds: int, seconds: float, target: Path | None) -> None:
    """Polish some designs in every way."""
    console = Console(width=100)
    console.print(report.machine_table(facts := report.machine()))
    rows = []
    for name in TASKS:
        for seed in range(seeds):
            scenario, one = searched(name, seed, seconds)
            task = PolishTask(scenario, one).task
            row: dict[str, Any] = {
                "task": name,
                "seed": seed,
                "start": float(task.worth(one).min()),
            }
            row |= dict(by_optimistix(scenario, task, one, steps))
            row["own"] = polished(task, one, steps, seed)
            console.print(row)
            rows.append(row)
    columns = [key for key in rows[0] if key not in ("task", "seed")]
    table = Table("task", *columns)
    for name in TASKS:
        own = [row for row in rows if row["task"] == name]
        table.add_row(name, *(f"{np.median([row[key] for row in own]):.0f}" for key in columns))
    console.print(table)
    if target:
        target.write_text(json.dumps({"machine": facts, "steps": steps, "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
