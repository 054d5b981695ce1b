"""What the benchmarks measure with and print."""

import os
import subprocess
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import contender
from rich.table import Table


def seconds(run: Callable[[], object]) -> float:
    """How long a call takes."""
    begun = time.perf_counter()
    run()
    return time.perf_counter() - begun


def machine() -> dict[str, str]:
    """Processor, cores and versions, as text."""
    gcc = subprocess.run(["gcc", "-dumpfullversion"], capture_output=True, text=True, check=True)
    return {
        "processor": contender.processor(),
        "cores": str(len(os.sched_getaffinity(0))),
        **{name: version(name) for name in ("jax", "numpy", "diffrax")},
        "gcc": gcc.stdout.strip(),
    }


def machine_table(facts: dict[str, str]) -> Table:
    """``machine()`` as a table."""
    table = Table(*facts)
    table.add_row(*facts.values())
    return table


def check_table(deviations: dict[str, float], tolerance: float) -> Table:
    """Largest relative deviation of each contender from float64."""
    table = Table("contender", title=f"Deviation from float64, allowed {tolerance:.0e}")
    table.add_column("largest relative deviation", justify="right")
    for name, deviation in deviations.items():
        table.add_row(name, f"{deviation:.1e}")
    return table


def population_table(row: dict[str, Any]) -> Table:
    """One population: every contender's speed, compile time and memory."""
    table = Table(
        "contender",
        title=f"{row['population']} individuals, {row['samples']} samples",
        caption="speed in individual-steps a second, memory at its peak beyond that of the imports",
    )
    for heading in ("speed", "evaluator / it", "compile, s", "memory, MB", "imports, MB"):
        table.add_column(heading, justify="right")
    for name, found in row["contenders"].items():
        imported = found["imported_bytes"]
        table.add_row(
            name,
            f"{found['steps_per_s']:.2e}",
            f"{found['ratio']:.2f}",
            f"{found['compile_s']:.1f}",
            f"{(found['peak_bytes'] - imported) / 1e6:.0f}",
            f"{imported / 1e6:.0f}",
        )
    return table


def memory_line(found: dict[str, float]) -> str:
    """The evaluator's memory for a long run of a large population."""
    return (
        f"evaluator alone, {found['population']} individuals, {found['samples']} samples: peak "
        f"memory {found['peak_bytes'] / 1e9:.2f} GB (allowed {found['limit_bytes'] / 1e9:.0f} GB), "
        f"{found['run_s']:.1f} s, {found['steps_per_s']:.2e} individual-steps/s"
    )
