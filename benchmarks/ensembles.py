"""Individuals on several machines beside as many on one, in one run.

    python benchmarks/ensembles.py [--individuals 1024] [--machines 16] [--repeats 9] [--json FILE]

The individuals and the 1,000 samples are those of ``evaluator.py``; the machines are within 20 %.
All contenders take their turns one after the other.
"""

import json
from pathlib import Path

import click
import evaluator_peer
import numpy as np
import report
from rich.console import Console
from rich.table import Table

SAMPLES = 1000


@click.command()
@click.option("--individuals", default=1024, type=click.IntRange(1), help="On every machine.")
@click.option("--machines", default=16, type=click.IntRange(2), help="Machines of each.")
@click.option("--repeats", default=9, type=click.IntRange(1), help="Turns of every contender.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the numbers there.")
def main(individuals: int, machines: int, repeats: int, target: Path | None) -> None:
    """Time the evaluator on one machine and on several, turn by turn."""
    console = Console(width=100)
    console.print(report.machine_table(facts := report.machine()))
    sizes = [(individuals, machines), (individuals, 1), (individuals * machines, 1)]
    works = [evaluator_peer.on_machines(evaluator_peer.make(n, SAMPLES), m) for n, m in sizes]
    turns = np.array([[report.seconds(run) for run in works] for _ in range(repeats)])
    speeds = np.array([n * m * SAMPLES for n, m in sizes]) / turns
    table = Table("individuals", "machines", "individual-steps/s", "robust / it")
    rows = []
    for k, (size, column) in enumerate(zip(sizes, speeds.T, strict=True)):
        ratio = float(np.median(speeds[:, 0] / speeds[:, k]))
        rows.append({"size": size, "steps_per_s": float(np.median(column)), "ratio": ratio})
        table.add_row(*map(str, size), f"{np.median(column):.2e}", f"{ratio:.2f}")
    console.print(table)
    if target:
        target.write_text(json.dumps({"machine": facts, "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
