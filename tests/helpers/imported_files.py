"""Files of other programs that the tests of the readers read."""

import random
from itertools import pairwise

from places import DATA

from hfc_design.runtime import Controller

SAMPLES = DATA / "imported"
MAMDANI_FLL = SAMPLES / "mamdani.fll"  # shapes, hedges, or, weights; by hand
MAMDANI_FIS = SAMPLES / "mamdani.fis"  # names that are no identifiers; by hand
MAMDANI_SIGNALS = {
    ".fll": {"level": "error", "rate": "error_change"},
    ".fis": {"Position error": "error", "d/dt error": "error_change"},
}
MAMDANI_SUM = SAMPLES / "mamdani-sum.fis"  # other shapes and norms, not, or, weights; by hand
PYFUZZYLITE = SAMPLES / "pyfuzzylite-8.0.6.fll"  # its FllExporter, nine decimals
OCTAVE = SAMPLES / "octave-fuzzy-logic-toolkit-0.4.6.fis"  # its writefis
SHARED = {suffix: SAMPLES / f"shared.{suffix}" for suffix in ("fll", "fis")}  # by hand
SHARED_SIGNALS = {"gap": "error", "drift": "error_change"}
GAUSSIAN = SAMPLES / "pyfuzzylite-8.0.6-gaussian.fll"  # 17 decimals; singletons i - j / 2

# Any seven overlapping triangles in any order, by hand in both languages.
CENTRES = (-9.5, -6.0, -1.0, 0.25, 2.0, 5.5, 12.0)
EDGES = [(a + 0.1, b - 0.3) for a, b in pairwise(CENTRES)]
ORDER = (3, 0, 6, 2, 5, 1, 4)
TABLE = [[random.Random(10 * i + j).uniform(-40, 40) for j in range(7)] for i in range(7)]


def triangles(labels):
    lefts, rights = [None, *(a for a, _ in EDGES)], [*(b for _, b in EDGES), None]
    return list(zip(labels, lefts, CENTRES, rights, strict=True))


def fll_text():
    lines = ["# by hand", "Engine: mine"]
    for name, prefix in (("change", "d"), ("error", "e")):
        lines += [f"InputVariable: {name}", "  enabled: true", "  range: -12.000 12.000"]
        rows = triangles([f"{prefix}{k}" for k in range(7)])
        for label, left, centre, right in (rows[k] for k in ORDER):
            if left is None:
                lines.append(f"  term: {label} Ramp {right!r} {centre!r}  # falls")
            elif right is None:
                lines.append(f"  term: {label} Trapezoid {left!r} {centre!r} 12 inf")
            else:
                lines.append(f"  term: {label} Triangle {left!r} {centre!r} {right!r} 1.0")
    lines += ["OutputVariable: u", "  range: -40 40", "  defuzzifier: WeightedAverage"]
    lines += [f"  term: u{i}{j} Constant {TABLE[i][j]!r}" for i in range(7) for j in range(7)]
    lines += ["RuleBlock:", "  conjunction: AlgebraicProduct", "  activation: General"]
    for i in range(7):
        for j in range(7):
            pair = [f"change is d{j}", f"error is e{i}"]
            lines.append(f"  rule: if {' and '.join(pair[:: (-1) ** i])} then u is u{i}{j}")
    return "\n".join(lines) + "\n"


def fis_text():
    lines = ["% by hand", "[System]", "Name='mine'", "Type='sugeno'", "Version=1.0", "NumInputs=2"]
    lines += ["NumOutputs=1", "NumRules=49", "AndMethod='prod'", "OrMethod='max'"]
    lines += ["ImpMethod='prod'", "AggMethod='sum'", "DefuzzMethod='wtaver'"]
    for n, name in ((1, "error"), (2, "change")):
        lines += ["", f"[Input{n}]", f"Name='{name}'", "Range=[-9.5 12]", "NumMFs=7"]
        rows = triangles([f"t{k}" for k in range(7)])
        for m, (label, left, centre, right) in enumerate((rows[k] for k in ORDER), 1):
            if left is None:
                shape = f"'linzmf',[{centre!r} {right!r}]"
            elif right is None:
                shape = f"'linsmf',[{left!r} {centre!r}]"
            else:
                shape = f"'trimf',[{left!r} {centre!r} {right!r}]"
            lines.append(f"MF{m}='{label}':{shape}")
    lines += ["[Output1]", "Name='u'", "Range=[-40 40]", "NumMFs=49"]
    cells = [(i, j) for i in range(7) for j in range(7)]
    for m, (i, j) in enumerate(cells, 1):
        lines.append(f"MF{m}='u{i}{j}':'constant',[{TABLE[i][j]!r}]")
    lines.append("[Rules]")
    for m, (i, j) in enumerate(cells, 1):
        lines.append(f"{ORDER.index(i) + 1} {ORDER.index(j) + 1}, {m} (1) : 1")
    return "\n".join(lines) + "\n"


TEXTS = {"fll": fll_text(), "fis": fis_text()}
CHANGE = {"change": "error_change"}


def output(design, error, change):
    """What a design, or its runtime, commands where the error has come from error - change."""
    runtime = design if isinstance(design, Controller) else Controller(design)
    runtime.remember({"error": error - change})
    return runtime.step({"error": error})
