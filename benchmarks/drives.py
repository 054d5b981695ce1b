"""The evaluator on the milling table and on five axes under PID, beside a hand-written C loop.

    python benchmarks/drives.py [--machines 1000] [--repeats 5] [--json FILE]

The C takes the same steps of the drives, float32, gcc -O3 -march=native -ffast-math -fopenmp, and
sums up the squares of each axis' error; the evaluator beside that does the contour and judges.
Fails where the errors of the C loop, in double, are not those of the evaluator in float64.
"""

import ctypes
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
import report
from c_peer import FLAGS, WIDE
from controllers import SPREAD, prepared
from numpy.typing import DTypeLike
from rich.console import Console
from rich.table import Table

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate

DESIGNS = {"huang-pid": "milling-table-circle", "lin-gai-2009-pid": "five-axis-program"}
TOLERANCE = 1e-6  # of the rms error of an axis
SERVO = (
    *("gain", "time_constant", "stiffness", "coulomb", "stiction_rise"),
    *("inverse_stribeck_velocity", "peak_force", "velocity_per_volt"),
)


class Axis(NamedTuple):
    """One call of the C loop."""

    function: str
    reference: np.ndarray  # (samples,)
    gains: np.ndarray  # (3, machines), the first as it is
    parameters: np.ndarray
    control: np.ndarray
    rms: float  # error of the first machine, by the evaluator in float64


def axes_of(design: str, scenario: str, machines: int) -> list[Axis]:
    """What the C loop has to do, an axis after the other."""
    loaded, found = load_design(design), load_scenario(scenario)
    evaluation = evaluate(loaded, found)
    generator = np.random.default_rng(0)
    axes = []
    for axis, own in zip(evaluation.axes, _each(loaded, len(evaluation.axes)), strict=True):
        c = axis.drive.coefficients(axis.parameters)
        spread = 1.0 + SPREAD * generator.uniform(-1.0, 1.0, (3, machines))
        spread[:, 0] = 1.0
        gains = np.array([[own.k_p], [own.k_i], [own.k_d]]) * spread
        table = hasattr(c, "axis")
        numbers = [*c.axis, c.force_gain] if table else [getattr(c, name) for name in SERVO]
        place = axis.motion.state.position
        count = c.scale_resolution if table else c.count
        limit = loaded.limits.command or np.inf
        control = [found.simulation.sample_time_s, limit, count, place[0]]
        off = axis.reference - place
        arrays = (axis.reference, gains, np.array(numbers), np.array(control))
        rms = float(np.sqrt(np.mean(off**2)))
        axes.append(Axis("table" if table else "servo", *arrays, rms))
    return axes


def _each(design: Any, count: int) -> list[Any]:
    """The PID gains of each axis."""
    records = design.controller.axis_records().values() if design.kind.axis_records else ()
    return [record.pid for record in records] or [design.controller.pid] * count


def built(*others: str) -> ctypes.CDLL:
    """The C loop, compiled."""
    wide = [WIDE] if "avx512f" in Path("/proc/cpuinfo").read_text() else []
    flags = [*FLAGS, *wide, *others]
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "drives.so"
        source = Path(__file__).with_name("drives.c")
        command = ["gcc", *flags, "-shared", "-fPIC", source, "-o", target, "-lm"]
        subprocess.run(command, check=True)
        return ctypes.CDLL(str(target))  # stays mapped when the file is gone


def scored(library: ctypes.CDLL, axes: list[Axis], real: DTypeLike = np.float32) -> np.ndarray:
    """Rms errors (axes, machines) by the C loop."""
    found = np.empty((len(axes), axes[0].gains.shape[1]), real)
    for axis, row in zip(axes, found, strict=True):
        sizes = ctypes.c_int(row.size), ctypes.c_int(axis.reference.size)
        told = (axis.reference, axis.gains, axis.parameters, axis.control)
        arrays = [*(np.ascontiguousarray(array, real) for array in told), row]
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
        getattr(library, axis.function)(*sizes, *pointers)
    return np.sqrt(found)


@click.command()
@click.option("--machines", default=1000, type=click.IntRange(1), help="Machines at once.")
@click.option("--repeats", default=5, type=click.IntRange(1), help="Turns of each.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the numbers there.")
def main(machines: int, repeats: int, target: Path | None) -> None:
    """Time both, turn by turn."""
    console, library, exact, rows = Console(width=100), built(), built("-DDOUBLE"), {}
    console.print(report.machine_table(facts := report.machine()))
    table = Table("design", title=f"{machines} machines, float32, medians of {repeats} turns")
    for heading in ("evaluator, axis-steps/s", "C", "evaluator / C", "C off by", "in float32"):
        table.add_column(heading, justify="right")
    for design, scenario in DESIGNS.items():
        work, axes = prepared(design, scenario, machines), axes_of(design, scenario, machines)
        nominal = np.array([axis.rms for axis in axes])
        found = scored(exact, axes, np.float64), scored(library, axes)
        off, single = (float(np.abs(own[:, 0] / nominal - 1.0).max()) for own in found)
        if not off <= TOLERANCE:  # a nan is none either
            raise click.ClickException(f"{design}: the C loop is off by {off:.1e} of an rms error")
        runs = (work.run, lambda axes=axes: scored(library, axes))
        turns = np.array([[report.seconds(run) for run in runs] for _ in range(repeats)])
        speeds = work.axis_steps / turns
        rows[design] = {
            "evaluator_axis_steps_per_s": float(np.median(speeds[:, 0])),
            "c_axis_steps_per_s": float(np.median(speeds[:, 1])),
            "ratio": float(np.median(speeds[:, 0] / speeds[:, 1])),
            "deviation": off,
            "float_deviation": single,
        }
        cells = zip(rows[design].values(), (".2e", ".2e", ".2f", ".1e", ".1e"), strict=True)
        table.add_row(design, *(format(value, form) for value, form in cells))
    console.print(table)
    if target:
        text = json.dumps({"machine": facts, "machines": machines, "designs": rows}, indent=1)
        target.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
