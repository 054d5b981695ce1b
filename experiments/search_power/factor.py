"""How much longer a lane of a Jacobian takes than a lane of a population: ``tasks.TANGENT``.

.venv-peers/bin/python -m experiments.search_power.factor
"""

from time import perf_counter

import click
import numpy as np

from experiments.search_power.tasks import GROUNDS, Field
from hfc_design.cli.usage import Plain
from hfc_design.controllers.genome import taken
from hfc_design.simulation import population as simulate

#: Lanes of a population, numbers of a Jacobian, tries of each in turn.
LANES, NUMBERS, TRIES = 1024, 96, 15


@click.command(cls=Plain)
def main() -> None:
    """Print the factor: medians of tries one after the other."""
    for task in ("ramp", "cutting"):
        field = Field(GROUNDS[task])
        genome = field.problem.genome
        loop, machines, motions = field.problem.loop, field.problem.machines, field.problem.motions
        tree = np.zeros(LANES, int)
        gains = genome.gains(genome.fresh(tree, np.random.default_rng(0)))
        one = genome.gains(taken(genome.fresh(tree, np.random.default_rng(0)), slice(1)))
        chosen = np.arange(NUMBERS)
        seconds = np.empty((TRIES + 1, 2))
        for k in range(TRIES + 1):
            begun = perf_counter()
            simulate.scores(loop, machines, motions, gains)
            between = perf_counter()
            simulate.jacobians(loop, machines, *motions, one, ("error",), chosen=chosen)
            seconds[k] = between - begun, perf_counter() - between
        plain, tangent = seconds[1:].T
        ratio = (tangent / NUMBERS) / (plain / LANES)
        low, middle, high = np.quantile(ratio, (0.25, 0.5, 0.75))
        click.echo(
            f"{task}: {1e3 * np.median(plain):.0f} ms for {LANES} lanes, "
            f"{1e3 * np.median(tangent):.0f} ms for {NUMBERS} numbers: "
            f"{middle:.2f} ({low:.2f} to {high:.2f}) times a lane"
        )


if __name__ == "__main__":
    main()
