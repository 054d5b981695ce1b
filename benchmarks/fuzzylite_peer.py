"""A design's units as engines of fuzzylite, stepped by pyfuzzylite or by its C++ library.

Scaling, clamping, memory and the PD part are done before for it: it is timed on the units alone.
Run as a program it is the pyfuzzylite side, in that library's own environment (NumPy < 2)::

    python fuzzylite_peer.py < WORK.json > RESULT.json
"""

import ctypes
import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

ENGINE = """Engine: unit
InputVariable: column
  enabled: true
  range: -1000.0 1000.0
  lock-range: false
{column}InputVariable: row
  enabled: true
  range: -1000.0 1000.0
  lock-range: false
{row}OutputVariable: output
  enabled: true
  range: -1000.0 1000.0
  lock-range: false
  aggregation: none
  defuzzifier: WeightedAverage TakagiSugeno
  default: 0.0
  lock-previous: false
{singletons}RuleBlock: rules
  enabled: true
  conjunction: AlgebraicProduct
  disjunction: none
  implication: none
  activation: General
{rules}"""


def engine(unit: Any) -> str:
    """FLL of one ``export.units.RuleUnit``."""
    cells = [(i, j) for i in range(7) for j in range(7)]
    return ENGINE.format(
        column="".join(map(_term, unit.column_terms)),
        row="".join(map(_term, unit.row_terms)),
        singletons="".join(f"  term: u{i}{j} Constant {unit.table[i][j]!r}\n" for i, j in cells),
        rules="".join(
            f"  rule: if row is {unit.row_terms[i].label} and column is "
            f"{unit.column_terms[j].label} then output is u{i}{j}\n"
            for i, j in cells
        ),
    )


def _term(term: Any) -> str:
    if hasattr(term, "sigma"):
        shape = f"GaussianProduct {term.low!r} {term.sigma!r} {term.high!r} {term.sigma!r}"
    elif math.isinf(term.left):
        shape = f"Ramp {term.right!r} {term.centre!r}"
    elif math.isinf(term.right):
        shape = f"Ramp {term.left!r} {term.centre!r}"
    else:
        shape = f"Triangle {term.left!r} {term.centre!r} {term.right!r}"
    return f"  term: {term.label} {shape}\n"


def compiled(engines: list[str], sources: list[tuple[int, int]]) -> Callable[..., Any] | None:
    """``run(inputs (n, k), outputs (n,))`` of the C++ library; None where it is not installed."""
    source = Path(__file__).with_name("fuzzylite_peer.cpp")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "peer.so"
        flags = ["-std=c++11", "-O2", "-w", "-shared", "-fPIC"]
        command = ["g++", *flags, source, "-o", target, "-lfuzzylite"]
        try:
            subprocess.run(command, check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            return None
        library = ctypes.CDLL(str(target))  # stays mapped when the file is gone
    library.prepare.restype = ctypes.c_void_p
    texts = (ctypes.c_char_p * len(engines))(*(text.encode() for text in engines))
    pairs = (ctypes.c_int * (2 * len(sources)))(*np.ravel(sources).tolist())
    machine = ctypes.c_void_p(library.prepare(len(engines), texts, pairs))

    def run(inputs: np.ndarray, outputs: np.ndarray) -> None:
        library.run(machine, *inputs.shape, inputs.ctypes, outputs.ctypes)

    return run


def interpreted(work: dict[str, Any]) -> dict[str, Any]:
    """Outputs and seconds a step of pyfuzzylite on ``work``: engines, sources, inputs."""
    import fuzzylite

    fuzzylite.settings.float_type = float
    importer = fuzzylite.FllImporter()
    engines = [importer.from_string(text) for text in work["engines"]]
    units = [(e, *e.input_variables, e.output_variables[0]) for e in engines]
    outputs, begun = [], time.perf_counter()
    for row in work["inputs"]:
        values = list(row)
        for (unit, column, other, output), source in zip(units, work["sources"], strict=True):
            column.value, other.value = values[source[0]], values[source[1]]
            unit.process()
            values.append(float(output.value))
        outputs.append(values[-1])
    return {"outputs": outputs, "step_s": (time.perf_counter() - begun) / len(outputs)}


if __name__ == "__main__":
    json.dump(interpreted(json.load(sys.stdin)), sys.stdout)
