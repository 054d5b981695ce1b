"""Time and memory of a generation for populations of 1,000 to 1,000,000, on every device.

    python benchmarks/populations.py [--populations 1000,1000000] [--platform cpu] [--json FILE]

Each population is a process of its own, so that its peak of memory is its own. A generation is
the scoring of all individuals: the C-axis over 1,000 samples, four fuzzy units each. With a GPU
``--platform cpu`` gives the same machine's processor beside it.
"""

import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import click
import evaluator_peer
import numpy as np
from evaluator import counts
from rich.console import Console
from rich.table import Table

SAMPLES = 1000


def measured(population: int, repeats: int) -> dict[str, Any]:
    """Seconds of a generation, memory and devices, in this process."""
    import jax

    work = evaluator_peer.many(population, SAMPLES)
    begun = time.perf_counter()
    run = evaluator_peer.prepare(work)
    first = time.perf_counter() - begun
    turns = []
    for _ in range(repeats):
        begun = time.perf_counter()
        run()
        turns.append(time.perf_counter() - begun)
    stats = jax.devices()[0].memory_stats() or {}
    return {
        "population": population,
        "generation_s": float(np.median(turns)),
        "steps_per_s": population * SAMPLES / float(np.median(turns)),
        "first_s": first,
        "peak_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        "device_bytes": stats.get("peak_bytes_in_use"),
        "devices": [device.device_kind for device in jax.devices()],
    }


@click.command()
@click.option("--populations", default="1000,10000,100000,1000000", callback=counts)
@click.option("--repeats", default=3, type=click.IntRange(1), help="Generations of each.")
@click.option("--platform", help="Of JAX: cpu or gpu [default: the best there is].")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the numbers there.")
@click.option("--only", type=int, hidden=True)
def main(
    populations: list[int],
    repeats: int,
    platform: str | None,
    target: Path | None,
    only: int | None,
) -> None:
    """Time generations of growing populations."""
    if only is not None:
        print(json.dumps(measured(only, repeats)))
        return
    environment = os.environ | ({"JAX_PLATFORMS": platform} if platform else {})
    rows = []
    for population in populations:
        command = [sys.executable, __file__, "--only", str(population), "--repeats", str(repeats)]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        rows.append(json.loads(done.stdout))
    devices = rows[0]["devices"]
    title = f"{len(devices)} x {devices[0]}, {SAMPLES} samples, float32"
    table = Table("individuals", title=title)
    for heading in ("generation, s", "individual-steps/s", "first, s", "memory, GB", "device, GB"):
        table.add_column(heading, justify="right")
    for row in rows:
        device = "-" if row["device_bytes"] is None else f"{row['device_bytes'] / 1e9:.2f}"
        table.add_row(
            f"{row['population']:,}",
            f"{row['generation_s']:.3f}",
            f"{row['steps_per_s']:.2e}",
            f"{row['first_s']:.1f}",
            f"{row['peak_bytes'] / 1e9:.2f}",
            device,
        )
    Console().print(table)
    if target:
        target.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
