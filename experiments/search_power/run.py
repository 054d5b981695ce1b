"""Run the experiment, or the rest of it: one small file for each method on each task.

.venv-peers/bin/python -m experiments.search_power.run
"""

import json
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

import click
import jax
import numpy as np

from experiments.search_power.finals import finals
from experiments.search_power.lockstep import CHECKS, ROBUST_CHECKS, together
from experiments.search_power.methods import DEFAULT, PAPER, method, names
from experiments.search_power.tasks import GROUNDS, TANGENT, Field
from hfc_design.cli.usage import Plain
from hfc_design.core.checkpoint import write_whole

SEEDS = 25


def file_of(out: Path, task: str, name: str) -> Path:
    """Where the results of a method on a task are."""
    plain = "".join(x if x.isalnum() else "-" for x in name.lower()).strip("-")
    return out / f"{task}.{plain}.json"


def measured(name: str, field: Field, seeds: list[int]) -> Mapping[str, Any]:
    """A method on a task."""
    begun = perf_counter()
    with click.progressbar(length=1000, label=f"{field.ground.name}: {name}") as bar:

        def told(share: float) -> None:
            bar.update(int(1000 * share) - bar.pos)

        found = together(method(name, field), field, seeds, told)
    searched = perf_counter() - begun
    final = finals(field, found)
    best = np.array([one.best for one in found]) if final.way is None else final.way
    return {
        "task": field.ground.name,
        "method": name,
        "seeds": seeds,
        "budget": field.budget,
        "individual": field.whole,
        "tangent": TANGENT,
        "shares": _short(CHECKS if field.single else ROBUST_CHECKS),
        "best": _short(best),
        "seconds": _short(np.array([one.seconds for one in found]), 3),
        "final": _short(final.final, 7),
        "spent": [one.spent for one in found],
        "trees": final.trees,
        "wall_s": [round(searched, 1), round(perf_counter() - begun - searched, 1)],
    }


def _short(values: Any, digits: int = 5) -> Any:
    """Plain numbers with few digits; null where there is none."""
    if np.ndim(values):
        return [_short(x, digits) for x in values]
    return float(f"{values:.{digits}g}") if np.isfinite(values) else None


@click.command(cls=Plain)
@click.option("--out", default="runs/search-power", type=click.Path(path_type=Path))
@click.option("--task", "tasks", multiple=True, type=click.Choice(list(GROUNDS)))
@click.option("--method", "methods", multiple=True, type=click.Choice(names()))
@click.option("--seeds", default=SEEDS, type=click.IntRange(1))
@click.option("--first", default=0, help="The first seed.")
@click.option("--share", default=1.0, type=click.FloatRange(0.001), help="Of the budget.")
def main(
    out: Path,
    tasks: tuple[str, ...],
    methods: tuple[str, ...],
    seeds: int,
    first: int,
    share: float,
) -> None:
    """Search; what stands in the folder already is not done again."""
    jax.config.update("jax_cpu_enable_async_dispatch", False)
    for task in tasks or GROUNDS:
        ground = GROUNDS[task]
        ground = ground._replace(budget=round(share * ground.budget))
        waiting = [one for one in methods or names() if not file_of(out, task, one).exists()]
        field = Field(ground) if waiting else None
        for name in waiting:
            assert field is not None
            numbers = list(range(first, first + seeds))
            if name in (DEFAULT, PAPER):  # compiles what it calls itself
                together(method(name, field), field, numbers[:1])
            found = measured(name, field, numbers)
            out.mkdir(parents=True, exist_ok=True)
            write_whole(file_of(out, task, name), (json.dumps(found) + "\n").encode())
            click.echo(f"{task}: {name}: median {np.median(np.array(found['final'], float)):.5g}, "
                       f"{sum(found['wall_s']):.0f} s")  # fmt: skip


if __name__ == "__main__":
    main()
