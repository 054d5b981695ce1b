"""A card beside the processor of the same machine: scores, evaluator, an ensemble, a search.

    python benchmarks/accelerator.py [--quick] [--backend cpu] [--parts check search] [--out FILE]

For a bare machine that has jax with CUDA and this checkout: nothing is fetched, and it ends within
four minutes. Each part is a process of its own, all on the processor first and then on the card;
one that fails or takes too long is a row of the table, and the others go on. The table is printed
as Markdown; FILE has the same as JSON, after every part. Ends with 1 where a part failed.
"""

import argparse
import json
import os
import platform
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

HERE = Path(__file__).parent
#: All that the parts import: what a bare machine lacks of it has to be carried there.
NEEDED = (
    "jax",
    "jaxtyping",
    "jinja2",
    "numpy",
    "pint",
    "psutil",
    "pydantic",
    "scipy",
    "threadpoolctl",
    "tomli_w",
)
BACKENDS, PARTS = ("cpu", "cuda"), ("check", "evaluator", "ensemble", "search")
#: Whether there is a card; and so many seconds until it has to be known.
PROBE, PROBE_S = "import jax; print(len(jax.devices()))", 40.0
LEGEND = """
A turn takes numbers on the host and gives back scores there, float32 over 1,000 samples; packing
them on the host and moving them to the first device are part of it, timed again on their own. A
turn of the search is a generation. Compiling is tracing, lowering and XLA.
"""


class Part(NamedTuple):
    """A row of the table for every backend: a function of ``accelerator_parts``, its arguments."""

    title: str  # begins with one of PARTS
    function: str
    given: list[Any]
    kept_s: float  # those before leave it so many seconds


def parts_of(names: list[str], quick: bool, file: Path) -> list[Part]:
    """What is measured on every backend; ``file`` is where the processor leaves exact scores."""
    populations = [(1000, 8.0)] if quick else [(10_000, 8.0), (100_000, 10.0), (1_000_000, 30.0)]
    small = {"controller.kind": "pd", "simulation.duration_s": 0.1}
    searched = ["c-axis-ramp", small, 3] if quick else ["c-axis-practical", {}, 10]
    many, machines = (64, 4) if quick else (1000, 100)
    every = [
        Part("check", "check", [str(file)], 12.0),
        *(Part(f"evaluator, {n:,}", "speed", [n, 1], kept) for n, kept in populations),
        Part(f"ensemble, {many:,} on {machines} machines", "speed", [many, machines], 12.0),
        Part(f"search, {searched[0]}, {searched[2]} generations", "search", searched, 45.0),
    ]
    return [part for part in every if part.title.partition(",")[0] in names]


def answered(backend: str, command: list[str], limit_s: float) -> dict[str, Any]:
    """What the last line of a Python program on a backend says, or why it says nothing."""
    from contender import ENVIRONMENT

    paths = filter(None, [str(HERE.parent), os.environ.get("PYTHONPATH")])
    own = ENVIRONMENT | {"JAX_PLATFORMS": backend, "PYTHONPATH": os.pathsep.join(paths)}
    limit = max(0.0, limit_s)
    kept: dict[str, Any] = {"capture_output": True, "text": True, "cwd": HERE, "timeout": limit}
    try:
        done = subprocess.run([sys.executable, *command], env=os.environ | own, check=False, **kept)
        return {"said": json.loads(done.stdout.splitlines()[-1])}
    except subprocess.TimeoutExpired:
        told = f"not finished in {limit:.0f} s" if limit else "no time was left"
        return {"state": "not measured", "told": told}
    except (IndexError, ValueError):  # it was killed, for one
        last = done.stderr.strip().splitlines()[-1:]
        return {"state": "failed", "told": ": ".join([f"ended with {done.returncode}", *last])}


def rows(backends: list[str], parts: list[Part], until: float) -> Iterator[dict[str, Any]]:
    """What each part says on each backend, all by a time of ``time.monotonic``."""
    card = answered("cuda", ["-c", PROBE], PROBE_S) if "cuda" in backends else {"told": ""}
    todo = [("cpu", part) for part in parts if "cpu" in backends or part.function == "check"]
    todo += [("cuda", part) for part in parts if "said" in card]
    for k, (backend, part) in enumerate(todo):
        spare = until - time.monotonic()
        kept = sum(other.kept_s for _, other in todo[k + 1 :])
        limit = min(spare, max(part.kept_s, spare - kept))
        given = [*part.given, limit / 2] if part.function == "speed" else part.given
        found = answered(backend, ["accelerator_parts.py", part.function, json.dumps(given)], limit)
        yield {"part": part.title, "on": backend, **found.pop("said", {}), **found}
    if card.get("told"):
        absent = {"on": "cuda", "state": "not measured", "told": f"no card: {card['told']}"}
        yield from ({"part": part.title, **absent} for part in parts)


def remark(row: dict[str, Any]) -> str:
    """What a row says in words."""
    if row["state"] != "measured":
        return f"{row['state']}: {row['told']}".replace("|", "/")
    if "deviation" in row:
        told = "from float64 {deviation:.1e} at most, {median_deviation:.1e} in the median"
        return told.format(**row)
    if "merit" in row:
        told = "{took_s:.1f} s, {first_s:.1f} s to the first generation; merit {merit:.4g}"
        return told.format(**row)
    return f"moves {row['moved_bytes'] / 1e6:.1f} MB" if "moved_bytes" in row else ""


def cells(row: dict[str, Any], processor_s: float | None) -> dict[str, str]:
    """A row of the table; ``processor_s`` is what the processor took for the same."""

    def numbers(form: str, unit: float, *keys: str) -> str:
        values = (row.get(key) for key in keys)
        found = ["-" if value is None else format(value / unit, form) for value in values]
        return "-" if set(found) == {"-"} else ", ".join(found)

    turns, times = row.get("turns_s"), "-"
    if row["on"] != "cpu" and "took_s" in row and processor_s:
        times = f"{processor_s / row['took_s']:.2f}"
    spread = f"{median(turns):.3g} ({min(turns):.3g} to {max(turns):.3g})" if turns else "-"
    return {
        "part": row["part"],
        "on": row.get("devices", row["on"]),
        "turn, median (min to max) [s]": spread,
        "individual-steps/s": numbers(".2e", 1, "steps_per_s"),
        "times the processor": times,
        "compile [s]": numbers(".1f", 1, "compile_s"),
        "packing, moving [s]": numbers(".2g", 1, "pack_s", "move_s"),
        "peak memory of device, host [GB]": numbers(".2f", 1e9, "device_bytes", "host_bytes"),
        "remark": remark(row),
    }


def markdown(report: dict[str, Any]) -> str:
    """On what it was measured, and the table, the rows of a part together."""
    titles = [row["part"] for row in report["rows"]]
    found = sorted(report["rows"], key=lambda row: titles.index(row["part"]))
    took_s = {row["part"]: row.get("took_s") for row in found if row["on"] == "cpu"}
    lines = [cells(row, took_s.get(row["part"])) for row in found]
    table = [list(lines[0]), ["---"] * len(lines[0]), *(list(line.values()) for line in lines)]
    told = ", ".join(f"{key} {value}" for key, value in report["run"].items())
    return "\n".join([told, "", *(f"| {' | '.join(line)} |" for line in table), LEGEND])


def printed(command: str) -> str:
    """What a command of the shell prints; "unknown" where it fails."""
    status, text = subprocess.getstatusoutput(f"timeout 10 {command}")
    return "unknown" if status else text


def main() -> int:
    """Measure and print the table; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--backend", nargs="+", choices=BACKENDS, default=BACKENDS)
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--quick", action="store_true", help="small sizes, to see that it works")
    parser.add_argument("--seconds", type=float, default=230.0, help="that all of it may take")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the numbers there, as JSON")
    asked = parser.parse_args()
    if lacking := " ".join(name.replace("_", "-") for name in NEEDED if find_spec(name) is None):
        parser.exit(
            2, f"missing: {lacking}; python -m pip install {lacking}, or carry the wheels\n"
        )
    from contender import processor  # needs numpy

    until = time.monotonic() + asked.seconds
    run = {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "commit": printed(f"git -C {shlex.quote(str(HERE))} describe --always --dirty"),
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "driver": printed("nvidia-smi --query-gpu=driver_version --format=csv,noheader"),
        "python": platform.python_version(),
        **{name: version(name) for name in ("jax", "jaxlib", "numpy")},
    }
    report: dict[str, Any] = {"run": run, "rows": []}
    with tempfile.TemporaryDirectory() as folder:
        parts = parts_of(asked.parts, asked.quick, Path(folder, "check.npz"))
        for row in rows(asked.backend, parts, until):
            report["rows"].append(row)
            print(row["part"], "on", row["on"], row["state"], file=sys.stderr)
            if asked.out:
                asked.out.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    print(markdown(report))
    return int(any(row["state"] == "failed" for row in report["rows"]))


if __name__ == "__main__":
    sys.exit(main())
