"""One step of an exported controller in C, beside the Python runtime and fuzzylite.

    python benchmarks/runtime.py [--repeats 7] [--json FILE]

Every contender steps through the same signals, recorded in a closed loop, and is checked against
the Python runtime before it is timed. They take their turns one after the other. A step is that of
one axis, or of all axes of a controller that commands a whole machine.
"""

import ctypes
import json
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import click
import fuzzylite_peer
import machine_steps
import numpy as np
import report
from designs import CROSS_COUPLED, NEURAL, design_of
from rich.console import Console
from rich.table import Table

from hfc_design.controllers.hierarchical.law import PREVIOUS
from hfc_design.controllers.hierarchical.record import HierarchicalDesign
from hfc_design.files.design import Design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import code
from hfc_design.formats.writing import rule_units, write
from hfc_design.runtime import Controller
from hfc_design.simulation.evaluating import evaluate

DESIGNS = {
    "lin-lee-1999-table-1": "c-axis-ramp-cutting",
    "jee-koren-2004-flc": "feed-drive-circle",
    "jee-koren-2004-aflc": "feed-drive-circle",
    "jee-koren-1995-soflc": "feed-drive-circle",
    "jee-koren-2004-pid": "feed-drive-circle",
    "huang-soc": "milling-table-circle",
    NEURAL: "milling-table-circle",
    "lin-gai-2009-fuzzy-sliding": "five-axis-program",  # X
    CROSS_COUPLED: "milling-table-circle",
    "lin-gai-2009-fuzzy-sliding-compensated": "five-axis-program",
}
POINTS = 257  # of the table variant
FEW = 100  # steps of the interpreted contenders
FUZZYLITE = Path(__file__).parents[1] / ".venv-fuzzylite" / "bin" / "python"
LOOP = """#include "{name}.h"
void run(int count, const {name}_inputs *inputs, {name}_real *commands)
{{
    {name}_state state;
    {name}_init(&state);
    for (int i = 0; i < count; i++) {{
        commands[i] = {name}_step(&state, &inputs[i]);
    }}
}}
"""


class Contender(NamedTuple):
    """Something that steps the design."""

    turn: Callable[[], float]  # seconds a step
    deviation: float  # largest one from the Python runtime, in the command's unit


def recorded(design: Design, scenario: str) -> np.ndarray:
    """What the first axis read at every sample of a closed loop, (samples, signals)."""
    motion = evaluate(design, load_scenario(scenario)).axes[0].motion
    known = {"error": motion.error, "error_rate": motion.error_rate}
    if design.plant.name == "c-axis":
        state = motion.state
        known["deflection"] = state.rotor_angle - state.spindle_angle
        known["deflection_rate"] = state.rotor_velocity - state.spindle_velocity
        known["spindle_velocity"] = state.spindle_velocity
    return np.stack([known[name] for name in code.signals(first_axis(design))], axis=1)


def first_axis(design: Design) -> Design:
    """The design of its first axis, or itself where all have the same."""
    return next(iter(design.by_axis().values()))


def contenders(design: Design, scenario: str) -> dict[str, Contender]:
    """Those that can step the design here, ready to run."""
    if design.kind.controller and not design.kind.axis_records:
        return of_machines(design, scenario)
    return of_axes(first_axis(design), recorded(design, scenario))


def of_machines(design: Design, scenario: str) -> dict[str, Contender]:
    seen = machine_steps.moments(design, scenario)
    expected, _ = machine_steps.expected(design, seen)
    samples, text = machine_steps.rows(design, seen), machine_steps.loop
    few = seen[:FEW]
    return {
        "C double": _c(design, samples, expected, loop=text),
        "C float": _c(design, samples, expected, "-DHFC_FLOAT", loop=text),
        "Python runtime": Contender(lambda: machine_steps.expected(design, few)[1], 0.0),
    }


def of_axes(design: Design, samples: np.ndarray) -> dict[str, Contender]:
    rows = [dict(zip(code.signals(design), row, strict=True)) for row in samples.tolist()]
    controller = Controller(design)
    expected = np.array([controller.step(row) for row in rows])

    def python() -> float:
        controller.reset()
        begun = time.perf_counter()
        for row in rows[:FEW]:
            controller.step(row)
        return (time.perf_counter() - begun) / FEW

    found = {
        "C double": _c(design, samples, expected),
        "C float": _c(design, samples, expected, "-DHFC_FLOAT"),
        "Python runtime": Contender(python, 0.0),
    }
    if isinstance(design.controller, HierarchicalDesign):
        found[f"C --lookup {POINTS}"] = _c(design, samples, expected, lookup=POINTS)
    if design.controller.kind in ("pd+hierarchical-fuzzy", "flc"):
        found |= _fuzzylite(design, samples, expected)
    return found


def _c(
    design: Design,
    samples: np.ndarray,
    expected: np.ndarray,
    *flags: str,
    lookup: int | None = None,
    loop: Callable[[Path, str], str] = lambda _, name: LOOP.format(name=name),
) -> Contender:
    """The exported code, built with gcc into a temporary directory."""
    real = np.float32 if flags else np.float64
    name = code.c_name(design)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "c"
        exact = lookup is None
        write(folder, code.sources(design) if exact else code.tabulated(design, lookup)[0])
        (folder / "loop.c").write_text(loop(folder, name), encoding="ascii")
        sources = sorted(folder.glob("*.c"))
        command = ["gcc", "-std=c99", "-O2", "-shared", "-fPIC", *flags, *sources, "-lm"]
        subprocess.run([*command, "-o", folder / "loop.so"], check=True)
        library = ctypes.CDLL(str(folder / "loop.so"))  # stays mapped when the file is gone
    inputs, commands = np.ascontiguousarray(samples, real), np.empty(expected.shape, real)

    def turn() -> float:
        begun = time.perf_counter()
        library.run(len(inputs), inputs.ctypes, commands.ctypes)
        return (time.perf_counter() - begun) / len(inputs)

    turn()
    return Contender(turn, float(np.abs(commands - expected).max()))


def _fuzzylite(design: Design, samples: np.ndarray, expected: np.ndarray) -> dict[str, Contender]:
    """The C++ library and pyfuzzylite on the units alone, where they are installed."""
    inputs, sources, scale, rest = _units(design, samples)
    engines = [fuzzylite_peer.engine(unit) for unit in rule_units(design)]
    outputs, found = np.empty(len(inputs)), {}
    if run := fuzzylite_peer.compiled(engines, sources):

        def turn() -> float:
            begun = time.perf_counter()
            run(inputs, outputs)
            return (time.perf_counter() - begun) / len(inputs)

        turn()
        off = float(np.abs(rest + scale * outputs - expected).max())
        found["fuzzylite, C++"] = Contender(turn, off)
    if FUZZYLITE.exists():
        few = {"engines": engines, "sources": sources, "inputs": inputs[:FEW].tolist()}
        text = json.dumps(few)

        def told() -> dict[str, list[float]]:
            command = [FUZZYLITE, fuzzylite_peer.__file__]
            answer = subprocess.run(command, input=text, capture_output=True, check=True, text=True)
            return json.loads(answer.stdout)

        commands = rest[:FEW] + scale * np.array(told()["outputs"])
        off = float(np.abs(commands - expected[:FEW]).max())
        found["pyfuzzylite"] = Contender(lambda: told()["step_s"], off)
    return found


def _units(
    design: Design, samples: np.ndarray
) -> tuple[np.ndarray, list[tuple[int, int]], float, np.ndarray]:
    """What the units read, (samples, inputs), their sources, and the command around them."""
    controller, names = design.controller, list(code.signals(design))
    before = np.concatenate([np.zeros((1, len(names))), samples[:-1]])
    if not isinstance(controller, HierarchicalDesign):
        error = samples[:, 0]
        inputs = np.stack([error - before[:, 0], error], axis=1)
        return inputs, [(0, 1)], 1.0, np.zeros(len(error))
    columns = []
    for item in controller.inputs:
        source = before if item.name.startswith(PREVIOUS) else samples
        place = names.index(item.name.removeprefix(PREVIOUS))
        columns.append(np.clip(item.scale * source[:, place], -1.0, 1.0))
    rest = controller.pd.kp * samples[:, 0] + controller.pd.kd * samples[:, 1]
    inputs = np.ascontiguousarray(np.stack(columns, axis=1))
    return inputs, controller.sources(), controller.output_scale, rest


@click.command()
@click.option("--repeats", default=7, type=click.IntRange(1), help="Turns of every contender.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write the numbers there.")
def main(repeats: int, target: Path | None) -> None:
    """Time one step, turn by turn."""
    console = Console(width=100)
    console.print(report.machine_table(facts := report.machine()))
    rows = {}
    for name, scenario in DESIGNS.items():
        ready = contenders(design_of(name), scenario)
        turns = np.array([[one.turn() for one in ready.values()] for _ in range(repeats)])
        table = Table(name, "ns a step", "it / C double", "deviation")
        for k, (who, one) in enumerate(ready.items()):
            found = {
                "step_ns": 1e9 * float(np.median(turns[:, k])),
                "ratio": float(np.median(turns[:, k] / turns[:, 0])),
                "deviation": one.deviation,
            }
            rows[f"{name}: {who}"] = found
            step, ratio, deviation = found.values()
            table.add_row(who, f"{step:,.0f}", f"{ratio:,.2f}", f"{deviation:.1e}")
        console.print(table)
    if not FUZZYLITE.exists():
        console.print(f"pyfuzzylite is not installed in {FUZZYLITE.parents[1]}: left out")
    if "jee-koren-2004-flc: fuzzylite, C++" not in rows:
        console.print("fuzzylite's C++ library (libfuzzylite-dev) is not installed: left out")
    if target:
        text = json.dumps({"machine": facts, "steps": rows}, indent=1)
        target.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
