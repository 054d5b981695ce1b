"""The population evaluator against its peers: speed, compile time and memory, in one run.

    python benchmarks/evaluator.py [--populations 30,1024] [--repeats 5] [--json FILE]

Fails where a contender does not compute what the evaluator computes in float64, or where the
evaluator needs more memory than it may.
"""

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
import evaluator_peer
import numpy as np
import report
from c_peer import WIDE
from contender import CONTENDERS, Contender
from rich.console import Console
from work import Work, save

#: Largest relative deviation of a score from float64; about 2e-5 is measured.
TOLERANCE = 1e-3
CHECKED, CHECK_SAMPLES = 64, 1000
LARGE, LARGE_SAMPLES, LARGE_BYTES = 65_536, 10_000, 2e9


def samples_of(population: int) -> int:
    """Control samples, so that every population but the largest is about the same work."""
    return min(2000, max(512, 2_048_000 // population))


@contextmanager
def started(name: str, work: Path) -> Iterator[Contender]:
    """A contender that ends with the block."""
    contender = Contender(name, work)
    try:
        yield contender
    finally:
        contender.close()


def names() -> list[str]:
    """The contenders that this processor can run; the evaluator is the first."""
    wide = "avx512f" in Path("/proc/cpuinfo").read_text()
    return [name for name, (_, set_up) in CONTENDERS.items() if wide or WIDE not in str(set_up)]


def check(folder: Path) -> dict[str, float]:
    """Largest relative deviation of each contender from the evaluator in float64, over 1 s."""
    work, exact = evaluator_peer.stable(CHECKED, CHECK_SAMPLES)
    file = folder / "check.npz"
    save(work, file)
    deviations = {}
    for name in names():
        with started(name, file) as contender:
            relative = np.abs(contender.scores / exact - 1.0)
        deviations[name] = float(relative.max())
        if not deviations[name] <= TOLERANCE:  # a nan is none either
            raise click.ClickException(
                f"{name} deviates by {deviations[name]:.1e} from float64, allowed is {TOLERANCE}"
            )
    return deviations


def measure(work: Work, file: Path, repeats: int) -> dict[str, dict[str, Any]]:
    """Name -> what was measured of it; every repeat gives each contender one turn."""
    save(work, file)
    contenders = []
    try:
        for name in names():
            contenders.append(Contender(name, file))
        turns = np.array([[c.turn() for c in contenders] for _ in range(repeats)])
        peaks = [contender.peak_bytes() for contender in contenders]
    finally:
        for contender in contenders:
            contender.close()
    return {
        contender.name: {
            "steps_per_s": work.steps / float(np.median(seconds)),
            "ratio": float(np.median(seconds / turns[:, 0])),
            "compile_s": contender.start.prepare_s,
            "peak_bytes": peak,
            "imported_bytes": contender.start.imported_bytes,
            "turns_s": seconds.tolist(),
        }
        for contender, seconds, peak in zip(contenders, turns.T, peaks, strict=True)
    }


def memory(folder: Path) -> dict[str, float]:
    """Peak memory and time of the evaluator for a long run of a large population."""
    work = evaluator_peer.make(LARGE, LARGE_SAMPLES)
    file = folder / "large.npz"
    save(work, file)
    with started("evaluator", file) as contender:
        found = {
            "population": LARGE,
            "samples": LARGE_SAMPLES,
            "peak_bytes": contender.peak_bytes(),
            "limit_bytes": LARGE_BYTES,
            "run_s": contender.start.run_s,
            "steps_per_s": work.steps / contender.start.run_s,
        }
    if found["peak_bytes"] >= LARGE_BYTES:
        raise click.ClickException(f"the evaluator needs {found['peak_bytes'] / 1e9:.2f} GB")
    return found


def counts(_context: Any, _option: Any, text: str) -> list[int]:
    """The numbers in "30,256"."""
    parts = text.split(",")
    if not all(part.strip().isdecimal() and int(part) > 0 for part in parts):
        raise click.BadParameter(f"{text!r} is not a list of whole numbers like 30,256")
    return [int(part) for part in parts]


@click.command()
@click.option(
    "--populations",
    default="30,256,1024,4096,65536",
    callback=counts,
    help="Individuals, separated by commas.",
)
@click.option("--repeats", default=5, type=click.IntRange(1), help="Turns of every contender.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the numbers there.")
def main(populations: list[int], repeats: int, target: Path | None) -> None:
    """Time the population evaluator against its peers on the same work."""
    if shutil.which("gcc") is None:
        raise click.ClickException("gcc is needed to build the C loop")
    console = Console(width=100)
    machine = report.machine()
    results: dict[str, Any] = {"machine": machine, "populations": []}
    console.print(report.machine_table(machine))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        results["deviations"] = check(folder)
        console.print(report.check_table(results["deviations"], TOLERANCE))
        for population in populations:
            samples = samples_of(population)
            work = evaluator_peer.make(population, samples)
            measured = measure(work, folder / f"{population}.npz", repeats)
            row = {"population": population, "samples": samples, "contenders": measured}
            results["populations"].append(row)
            console.print(report.population_table(row))
        results["memory"] = memory(folder)
        console.print(report.memory_line(results["memory"]))
    if target:
        target.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
