"""What the page of Huang & Shy reads off the motions: errors of the axes, times, draws, laps."""

import csv
from functools import reduce
from pathlib import Path

import numpy as np

from experiments.shared import Batch, Floats, calculated, markdown
from experiments.steps import Ranged
from hfc_design.files.loop_setup import load_design
from hfc_design.motion.reversals import after_reversals, undisturbed
from hfc_design.simulation.evaluating import Evaluation, evaluate

LAPS = 8  # of laps.toml
#: Figure, label, axis, and what is printed of it away from its reversals and in them [mm].
OF_AXES = (
    ("5", "SOC", "x", 0.02, 0.04),
    ("6", "SOC", "y", 0.01, 0.04),
    ("7", "neural", "x", 0.01, 0.02),
    ("8", "neural", "y", 0.01, 0.02),
)
HERE = Path(__file__).parent
#: Who is drawn again, on which circle, and the gain that differs by millionths.
DRAWN = (
    ("PID", "60", "huang-pid", "controller.pid.k_p"),
    ("cross-coupling", "60", "huang-cross-coupled", "controller.contour.k_p"),
    ("SOC", "60", "huang-soc", "controller.gu"),
    ("neural", "60", "huang-neural", "controller.command_unit"),
    ("SOC goes on", "25", str(HERE / "soc-lap-1.json"), "controller.axes.x.gu"),
    ("neural goes on", "25", str(HERE / "neural-lap-1.json"), "controller.axes.x.command_unit"),
)
SCENARIOS = {"60": "milling-table-circle", "25": "milling-table-small-circle"}
PEAKS = ("path_error_mm", "worst_glitch_mm")


def of_axis(found: Evaluation, name: str) -> tuple[float, float]:
    """Largest tracking error away from an axis' start and reversals, and in the latter [mm].

    Until 45 s, where the time of the figures ends and the machine begins to stop.
    """
    k = [axis.name for axis in found.axes].index(name)
    until = int(np.searchsorted(found.time, 45.0))
    error, velocity = found.axes[k].motion.error, found.contour.samples.velocity[k]
    time, error, velocity = (own[:until] for own in (found.time, error, velocity))
    quiet = undisturbed(time, velocity[None])
    after = after_reversals(time, {name: velocity}, error)
    return float(np.abs(error[quiet]).max()), max(abs(glitch.error) for glitch in after)


def axes(batch: Batch) -> list[list[str]]:
    """Rows of ``HEAD`` of figs. 5 to 8."""
    rows = []
    for figure, label, axis, *printed in OF_AXES:
        each = zip(*(of_axis(found, axis) for found in batch.motions(label)), strict=True)
        for what, value, own in zip(("tracking error", "impulse"), printed, each, strict=True):
            rows.append(
                calculated(
                    figure, f"{label}, 60 mm: {what} of {axis} [mm]", value, Ranged.among(own)
                )
            )
    return rows


def learning(batch: Batch) -> list[list[str]]:
    """Rows of ``HEAD``: how long what begins without a rule exceeds what is printed of it."""
    rows = []
    for label, printed in (("SOC", 0.015), ("25 mm, SOC", 0.01)):
        what = f"{label}: last beyond {printed:g} mm but for reversals [s]"
        last = [
            _last(
                found.time, np.where(found.contour.undisturbed, found.contour.error, 0.0), printed
            )
            for found in batch.motions(label)
        ]
        rows.append(calculated("-", what, None, Ranged.among(last)))
    what = "sine, SOC: last beyond 0.03 mm in the first half [s]"
    last = [
        _last(sine.time[half], sine.axes[0].motion.error[half], 0.03)
        for sine in batch.motions("sine, SOC")
        for half in [sine.time < 10.0]
    ]
    return [*rows, calculated("3", what, None, Ranged.among(last))]


def _last(time: Floats, error: Floats, limit: float) -> float:
    """The last time [s] at which an error is beyond a limit."""
    return float(time[np.flatnonzero(np.abs(error) > limit)[-1]])


def drawn(name: str, scenario: str, key: str, count: int) -> Floats:
    """(count, 2) ``PEAKS`` [mm] of a design whose gain ``key`` differs by millionths."""
    gain = reduce(lambda part, word: part[word], key.split("."), load_design(name).model_dump())
    found = []
    for k in range(count):
        metrics = evaluate(load_design(name, {key: gain * (1 + 1e-6 * k)}), scenario).metrics
        found.append([metrics[peak] for peak in PEAKS])
    return np.array(found, np.float64)


def draws(count: int = 15) -> str:
    """Medians and ranges of ``DRAWN`` with a gain that differs by millionths: chaotic loops."""
    rows = []
    for label, radius, name, key in DRAWN:
        found = drawn(name, SCENARIOS[radius], key, count)
        told = [f"{np.median(peak):.3g} ({min(peak):.3g} to {max(peak):.3g})" for peak in found.T]
        rows.append([label, f"{radius} mm", *told])
    return markdown(("controller", "circle", "path error [mm]", "impulse [mm]"), rows)


def of_laps(batch: Batch, label: str) -> list[list[float]]:
    """Path error and impulse [mm] of each lap."""
    names = [[f"lap_{k + 1}_{peak}" for peak in PEAKS] for k in range(LAPS)]
    return [[value or 0.0 for value in batch.values(label, *own)] for own in names]


def machines(comparison: Path) -> str:
    """Medians and 95 % of path error and impulse over the machines of a ``comparison.csv``."""
    found: dict[tuple[str, str], list[list[float]]] = {}
    stable: dict[tuple[str, str], list[int]] = {}
    with comparison.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["machine"] != "0":  # the nominal one
                own = row["motion"], row["design"]
                peaks = [float(row[peak] or "inf") for peak in PEAKS]
                found.setdefault(own, []).append(peaks)
                stable.setdefault(own, []).append(int(row["stable"]))
    rows = []
    for own, peaks in found.items():
        middle, high = np.percentile(peaks, (50, 95), axis=0)
        told = [f"{a:.3g} / {b:.3g}" for a, b in zip(middle, high, strict=True)]
        rows.append([*own, *told, f"{100 * np.mean(stable[own]):.0f} %"])
    heads = ("scenario", "design", "path error, median / 95 % [mm]", "impulse [mm]", "settles")
    return markdown(heads, rows)


def laps(batch: Batch) -> str:
    """Table of the laps of both that learn."""
    both = [of_laps(batch, f"laps, {label}") for label in ("SOC", "neural")]
    rows = [
        [str(k + 1), *(f"{value:.3g}" for own in both for value in own[k])] for k in range(LAPS)
    ]
    heads = [f"{label}: {what} [mm]" for label in ("SOC", "neural") for what in ("path", "impulse")]
    return markdown(("lap of 45 s", *heads), rows)
