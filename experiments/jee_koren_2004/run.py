"""The figures of Jee & Koren 2004 (JK04), simulated; see README.md beside this file.

Run from the root of the repository: ``.venv/bin/python -m experiments.jee_koren_2004.run``.
"""

from pathlib import Path
from time import perf_counter

import click
import numpy as np
from matplotlib.figure import Figure

from experiments.shared import Cycles, Row, changed, curves, cycles, in_cycles, markdown, rms, run
from experiments.shared import write_tables as write
from hfc_design.evaluate import Evaluation, load_design
from hfc_design.laws.rule_bases import rule_labels, rule_singletons
from hfc_design.pictures.plots import save
from hfc_design.runtime import Controller
from hfc_design.stability.plot import stability_figure
from hfc_design.stability.stable_range import stable_range, theorem_k1
from plants.feed_drive import PARAMETER_SETS

HERE = Path(__file__).parent
PID, FLC, AFLC = "jee-koren-2004-pid", "jee-koren-2004-flc", "jee-koren-2004-aflc"
STEP = 20.0  # of step.toml [BLU]
#: The friction of JK04 eq. 28, X axis, as changes of step.toml.
EQ_28 = [
    f"plant.parameters.{key}={getattr(PARAMETER_SETS['x-start'], key)}"
    for key in ("positive_start", "positive_slope", "positive_curvature",
                "negative_start", "negative_slope", "negative_curvature")
]  # fmt: skip
#: JK04 eq. 28 of the X axis, for the figures of the real machine.
LOW_VELOCITY = {
    "forward": [0.05, -1.16, 6.54],
    "backward": [-0.04, -1.0, -6.43],
    "highest_velocity_mm_s": 12.0,
    "breakaway": [6.54, -6.43],
    "smallest_error": 2.0,
}


def stability(out: Path) -> list[Row]:
    """Fig. 4: the stable range. The paper prints the curve; the numbers are its equations'."""
    found = stable_range(28.3, 0.055, 0.01)
    save(stability_figure(found, {"rule base I at its centres": (32.0 / 21.0, 16.0 / 3.0)}), out)
    equations = "its equations, evaluated independently; the paper prints a curve only"
    linear = "where the linear loop u = K_1 e becomes unstable"
    return [
        Row("4", "K_1, eq. 21 as printed [unit/BLU]", 9.0364, found.k1_printed, equations),
        Row("4", "K_2 at K_1 = 4.518, eq. 22 [unit/BLU]", 5.895, float(found.k2(4.518)), equations),
        Row("4", "K_1 that this project allows [unit/BLU]", None, found.k1, linear),
        Row("4", "K_1, eq. 21 with the right sign [unit/BLU]", None, theorem_k1(found.drive)),
    ]


def circle(out: Path, *changes: str) -> list[Row]:
    """Fig. 10: circle of 40 mm, three cycles, no integral term."""
    flc, aflc = (run(design, HERE / "circle.toml", *changes) for design in (FLC, AFLC))
    save(_both(flc, aflc, {"axial error X [BLU]": {"RMS of the FLC in the paper": 16.2}}), out)
    fixed, adaptive = cycles(flc), cycles(aflc)
    factor = fixed.contour[-1] / adaptive.contour[-1]
    by_encoder = _seen(flc) / _seen(aflc)
    return [
        Row("10", "FLC: axial RMS, cycle 1 [BLU]", 16.2, fixed.axial[0]),
        Row("10", "FLC: axial RMS, cycle 3 [BLU]", 16.2, fixed.axial[-1]),
        Row("10", "AFLC: axial RMS, cycle 1 [BLU]", 9.6, adaptive.axial[0], "learns faster here"),
        Row("10", "AFLC: axial RMS, cycle 3 [BLU]", 5.6, adaptive.axial[-1]),
        Row("10", "FLC: contour RMS, cycle 3 [BLU]", None, fixed.contour[-1]),
        Row("10", "AFLC: contour RMS, cycle 3 [BLU]", None, adaptive.contour[-1]),
        Row("10", "contour RMS, FLC / AFLC, cycle 3", 4.0, factor, "see the second table"),
        Row("10", "contour RMS, FLC / AFLC, cycle 3", 4.0, by_encoder, "from encoder readings"),
    ]


def line(out: Path) -> list[Row]:
    """Fig. 11: line at 26.6 deg with K_I = 8, and what else the AFLC does there."""
    flc, aflc = (run(changed(name, integral_gain=8.0), HERE / "line.toml") for name in (FLC, AFLC))
    save(_both(flc, aflc, {"contour error [BLU]": {"FLC in the paper": 5.0}}), out)
    narrow = changed(AFLC, integral_gain=8.0, adaptation=_overlap(0.5, 0.125))
    others = {
        "K = 28.3": run(
            changed(AFLC, integral_gain=8.0), HERE / "line.toml", "plant.parameters.gain=28.3"
        ),
        "overlap of one step": run(narrow, HERE / "line.toml"),
        "no friction": run(changed(AFLC, integral_gain=8.0), HERE / "line-frictionless.toml"),
        "K_I = 2": run(changed(AFLC, integral_gain=2.0), HERE / "line.toml"),
        "K_I = 2, overlap of one step": run(
            changed(AFLC, integral_gain=2.0, adaptation=_overlap(0.5, 0.125)), HERE / "line.toml"
        ),
    }
    words = '"almost zero"; 1.5 the best that a control can achieve'
    largest = "largest contour error after 5 s [BLU]"
    return [
        Row("11", f"FLC: {largest}", 5.0, _late(flc)),
        Row("11", f"AFLC: {largest}", 1.5, _late(aflc), words),
        *(Row("11", f"AFLC: {largest}", 1.5, _late(item), name) for name, item in others.items()),
    ]


def _late(evaluation: Evaluation) -> float:
    """Largest contour error after 5 s [BLU]."""
    return float(np.abs(evaluation.contour.error[evaluation.time >= 5.0]).max())


def friction(out: Path) -> list[Row]:
    """Fig. 12: circle of 20 mm with and without friction; the third cycle."""
    start, coulomb, none = (
        HERE / f"slow-circle{name}.toml" for name in ("", "-coulomb", "-frictionless")
    )
    aflc = changed(AFLC, integral_gain=8.0)
    narrow = changed(AFLC, integral_gain=8.0, adaptation=_overlap(0.5, 0.125))
    kinds = {"F_c = 15": coulomb, "eq. 28 alone": start, "no friction": none}
    adaptive = {name: run(aflc, file) for name, file in kinds.items()}
    pid = {name: run(PID, file) for name, file in kinds.items()}
    printed = cycles(run(PID, coulomb, "plant.parameters.gain=28.3"))
    last = slice(2 * len(pid["no friction"].time) // 3, None)
    panels = {
        f"contour error, {name} [BLU]": {k: item.contour.error[last] for k, item in part.items()}
        for name, part in (("AFLC", adaptive), ("PID", pid))
    }
    levels = {"contour error, PID [BLU]": {"PID in the paper": 15.6}}
    save(curves(pid["no friction"].time[last], panels, levels), out)
    with_, without = ("contour RMS with friction [BLU]", "contour RMS without friction [BLU]")
    rows = [
        Row("12a", f"AFLC: {without}", 1.1, cycles(adaptive["no friction"]).contour[-1], "K_I = 8")
    ]
    for name, file in (("eq. 28 alone", start), ("F_c = 15", coulomb)):
        found = {
            "K_I = 8": adaptive[name],
            "K_I = 0": run(AFLC, file),
            "K_I = 8, overlap of one step": run(narrow, file),
        }
        rows += [
            Row("12a", f"AFLC: {with_}", 1.5, cycles(item).contour[-1], f"{name}, {words}")
            for words, item in found.items()
        ]
    rows.append(Row("12b", f"PID: {without}", 1.5, cycles(pid["no friction"]).contour[-1]))
    found = {name: cycles(pid[name]) for name in ("F_c = 15", "eq. 28 alone")}
    for words, item in {**found, "F_c = 15, K = 28.3": printed}.items():
        rows.append(Row("12b", f"PID: {with_}", 3.4, item.contour[-1], words))
        rows.append(Row("12b", "PID: largest contour error [BLU]", 15.6, item.largest[-1], words))
    return rows


def rule_bases(out: Path) -> list[Row]:
    """Fig. 18: step responses of the rule bases."""
    found = {
        base: run(
            changed(FLC, rules={"labels": rule_labels(base), "centroids": rule_singletons(base)}),
            HERE / "step.toml",
        )
        for base in ("I", "II", "III")
    }
    position = {
        f"rule base {base}": item.axes[0].motion.state.position for base, item in found.items()
    }
    label = "position [BLU]"
    save(curves(found["I"].time, {label: position}, {label: {"reference": STEP}}), out)
    words = {"I": "the best in the paper", "II": "", "III": "slightly worse than II in the paper"}
    rows = []
    for base, item in found.items():
        error = item.axes[0].motion.error
        there = np.flatnonzero(error <= 0.1 * STEP)
        away = np.flatnonzero(np.abs(error) > 0.1 * STEP)[-1] + 1
        rows += [
            Row("18", f"base {base}: 90 % reached [s]", None, item.time[there[0]]),
            Row("18", f"base {base}: overshoot [BLU]", None, max(0.0, -error.min())),
            Row("18", f"base {base}: settled within 10 % [s]", None,
                item.time[away] if away < len(error) else np.nan),
            Row("18", f"base {base}: integral of the error's magnitude [BLU s]", None,
                np.abs(error).sum() * 0.01, words[base]),
        ]  # fmt: skip
    return rows


def machine(out: Path) -> list[Row]:
    """Table 4 and figs. 13-16, in trend: low-velocity compensation and K_I = 8 on the circle."""
    settings = {"integral_gain": 8.0, "low_velocity": LOW_VELOCITY}
    flc, aflc = changed(FLC, **settings), changed(AFLC, **settings)
    straight = [run(design, HERE / "steep-line.toml").contour.error for design in (flc, aflc)]
    bent = [cycles(run(design, HERE / "circle.toml")) for design in (flc, aflc)]
    plain = [
        cycles(run(changed(name, low_velocity=LOW_VELOCITY), HERE / "circle.toml"))
        for name in (FLC, AFLC)
    ]
    slot = run(aflc, HERE / "slot.toml")
    cut, slower = (
        cycles(item)
        for item in (
            slot,
            run(changed(AFLC, **settings, adaptation={"k_c": 0.2}), HERE / "slot.toml"),
        )
    )
    tuned, pid = (cycles(run(item, HERE / "slow-circle-coulomb.toml")) for item in (aflc, PID))
    save(curves(slot.time, {"contour error [BLU]": {"AFLC in a slot": slot.contour.error}}), out)
    trend = "real machine"
    return [
        Row("Table 4", "line: contour RMS, FLC / AFLC", 1.7 / 0.9,
            rms(straight[0]) / rms(straight[1]), trend),
        Row("Table 4", "circle: contour RMS, FLC / AFLC, cycle 3", 4.0 / 1.9,
            bent[0].contour[-1] / bent[1].contour[-1], trend),
        Row("Table 4", "circle: contour RMS, FLC / AFLC, cycle 3", 4.0 / 1.9,
            plain[0].contour[-1] / plain[1].contour[-1], f"{trend}; without integral term"),
        Row("14", "circle: largest contour error, FLC / AFLC, cycle 3", 14.3 / 6.4,
            bent[0].largest[-1] / bent[1].largest[-1], trend),
        Row("14", "circle: largest contour error, FLC / AFLC, cycle 3", 14.3 / 6.4,
            plain[0].largest[-1] / plain[1].largest[-1], f"{trend}; without integral term"),
        Row("15", "slot: largest contour error, cycle 1 / cycle 3", 2.0,
            cut.largest[0] / cut.largest[-1], f"{trend}; the force is assumed"),
        Row("15", "slot: largest contour error, cycle 1 / cycle 3", 2.0,
            slower.largest[0] / slower.largest[-1], f"{trend}; the force is assumed; K_C = 0.2"),
        Row("16", "circle: contour RMS, PID / tuned AFLC", 2.6,
            pid.contour[-1] / tuned.contour[-1], f"{trend}; Coulomb friction of 15 units"),
        Row("16", "circle: largest contour error, PID / tuned AFLC", 2.9,
            pid.largest[-1] / tuned.largest[-1], f"{trend}; Coulomb friction of 15 units"),
    ]  # fmt: skip


def computing() -> list[Row]:
    """Section 6: time that one axis takes in a sample, here of the runtime in Python."""
    found = []
    for name in (AFLC, FLC):
        controller = Controller(load_design(name))
        errors = np.round(20.0 * np.sin(0.01 * np.arange(2000))).tolist()
        begun = perf_counter()
        for error in errors:
            controller.step({"error": error})
        found.append(1e3 * (perf_counter() - begun) / len(errors))
    here = "a 486 at 33 MHz there, Python here"
    return [
        Row("6", "AFLC: time of a sample [ms]", 0.4, found[0], here),
        Row("6", "FLC: time of a sample [ms]", 0.3, found[1], here),
    ]


def _limits(k1: float, k2: float) -> dict[str, dict[str, float]]:
    return {"stable_range": {"k1_max": k1, "k2_max": k2}}


def _overlap(error: float, change: float) -> dict[str, dict[str, float]]:
    return {"smallest_overlap": {"error": error, "error_change": change}}


#: What the paper leaves open, one change each from the built-in design.
VARIANTS = {
    "as built in: overlap 3 and 0.5 BLU, K_1 to 4.5, K_2 to 5.9": {},
    "overlap of one step, 0.5 and 0.125 BLU": {"adaptation": _overlap(0.5, 0.125)},
    "overlap 2 and 0.375 BLU": {"adaptation": _overlap(2.0, 0.375)},
    "overlap 5 and 1 BLU": {"adaptation": _overlap(5.0, 1.0)},
    "overlap 7 and 1.5 BLU: to the neighbours' centres": {"adaptation": _overlap(7.0, 1.5)},
    "terms stay as in Table 3 (K_A = K_B = 0)": {"adaptation": {"k_a": 0.0, "k_b": 0.0}},
    "only the terms move (K_C = 0)": {"adaptation": {"k_c": 0.0}},
    "all steps halved": {"adaptation": {"k_a": 0.25, "k_b": 0.0625, "k_c": 0.5}},
    "K_C = 0.2": {"adaptation": {"k_c": 0.2}},
    "K_1 to 3.2, K_2 to 4.17: inside the range of K = 40": {"adaptation": _limits(3.2, 4.17)},
    "K_1 to 4, K_2 to 5.9": {"adaptation": _limits(4.0, 5.9)},
    "K_1 to 4, K_2 to 6.79: another point of fig. 4": {"adaptation": _limits(4.0, 6.79)},
    "the same and K_C = 0.2": {"adaptation": _limits(4.0, 6.79) | {"k_c": 0.2}},
    "K_1 to 4.5, K_2 free": {"adaptation": _limits(4.5, 1e3)},
    "K_1 to 6.3, K_2 free": {"adaptation": _limits(6.3, 1e3)},
    "one step, K_1 to 3.2, K_2 to 4.17": {
        "adaptation": _overlap(0.5, 0.125) | _limits(3.2, 4.17)
    },
    "one step, K_1 to 4.5, K_2 free": {"adaptation": _overlap(0.5, 0.125) | _limits(4.5, 1e3)},
    "one step, K_1 to 6.3, K_2 free": {"adaptation": _overlap(0.5, 0.125) | _limits(6.3, 1e3)},
    "integral gain 8": {"integral_gain": 8.0},
    "low-velocity compensation (eq. 28)": {"low_velocity": LOW_VELOCITY},
}  # fmt: skip


def variants(names: tuple[str, ...] = tuple(VARIANTS)) -> tuple[str, dict[str, Cycles]]:
    """What each setting does to fig. 10, as a table and as figures."""
    scenario = HERE / "circle.toml"
    fixed = cycles(run(FLC, scenario))
    found = {name: cycles(run(changed(AFLC, **VARIANTS[name]), scenario)) for name in names}
    lines = [
        [
            name,
            *(f"{item.axial[k]:.1f}" for k in (0, 1, 2)),
            *(f"{item.contour[k]:.2f}" for k in (0, 1, 2)),
            f"{item.largest[-1]:.1f}",
            f"{item.unrest[-1]:.1f}",
            f"{fixed.contour[-1] / item.contour[-1]:.1f}",
        ]
        for name, item in {"the FLC": fixed, **found}.items()
    ]
    header = ["AFLC on the circle of fig. 10", "axial 1", "2", "3", "contour 1", "2", "3",
              "largest", "unrest", "FLC / AFLC"]  # fmt: skip
    return markdown(header, lines), found


#: Gain K, Coulomb friction F_c and how far stiction rises above it, of the third table.
FRICTION = ((28.3, 0.0, 0.0), (28.3, 15.0, 0.0), (40.0, 0.0, 0.0), (40.0, 5.0, 0.0),
            (40.0, 10.0, 0.0), (40.0, 15.0, 0.0), (40.0, 0.0, 20.0), (57.0, 4.0, 0.0),
            (57.0, 4.0, 20.0), (91.0, 8.0, 0.0), (92.0, 8.0, 15.0), (100.0, 9.0, 15.0),
            (107.0, 10.0, 10.0))  # fmt: skip


def friction_sets(sets: tuple[tuple[float, float, float], ...] = FRICTION) -> str:
    """What gain and friction do to the figures that have numbers, as a table."""
    lines = [["the paper", "", "", "16.2", "3.4", "15.6", "1.5", "5.6", "4", "1.5"]]
    for gain, coulomb, rise in sets:
        changes = [
            f"plant.parameters.{key}={value}"
            for key, value in (("gain", gain), ("coulomb", coulomb), ("stiction_rise", rise))
        ]
        flc, aflc = (cycles(run(name, HERE / "circle.toml", *changes)) for name in (FLC, AFLC))
        pid, slow = (cycles(run(name, HERE / "slow-circle.toml", *changes)) for name in (PID, AFLC))
        easy = cycles(run(PID, HERE / "slow-circle-frictionless.toml", changes[0]))
        follows = flc.axial[-1] < 100.0  # else the largest singleton is too small
        lines.append([
            *(f"{value:g}" for value in (gain, coulomb, rise)),
            f"{flc.axial[-1]:.3g}" if follows else "cannot follow",
            *(f"{value:.3g}" for value in (pid.contour[-1], pid.largest[-1], easy.contour[-1])),
            f"{aflc.axial[-1]:.3g}",
            f"{flc.contour[-1] / aflc.contour[-1]:.2f}" if follows else "-",
            f"{slow.contour[-1]:.3g}",
        ])  # fmt: skip
    header = ["K", "F_c", "rise", "FLC axial", "PID contour", "PID largest", "PID, no friction",
              "AFLC axial", "FLC / AFLC", "AFLC, fig. 12a"]  # fmt: skip
    return markdown(header, lines)


def heights(values: tuple[float, ...] = (10.0, 20.0, 30.0, 50.0, 100.0)) -> str:
    """Integral of the error's magnitude of the steps of fig. 18, by height, gain and friction."""
    designs = {
        base: changed(FLC, rules={"labels": rule_labels(base), "centroids": rule_singletons(base)})
        for base in ("I", "II", "III")
    }
    lines = []
    for gain in (28.3, 40.0):
        for words, curve in (("none", []), ("eq. 28", EQ_28)):
            for height in values:
                changes = [f"reference.height={height}", f"plant.parameters.gain={gain}", *curve]
                found = (run(design, HERE / "step.toml", *changes) for design in designs.values())
                errors = [np.abs(item.axes[0].motion.error).sum() * 0.01 for item in found]
                lines.append([f"{gain:g}", words, f"{height:g}", *(f"{x:.2f}" for x in errors)])
    return markdown(["K", "friction", "height [BLU]", "I", "II", "III"], lines)


def _seen(evaluation: Evaluation) -> float:
    """Contour RMS of the last of three cycles of ``circle.toml`` by the encoders [BLU]."""
    x, y = (np.round(axis.motion.state.position) for axis in evaluation.axes)
    return rms(in_cycles(np.hypot(x + 4000.0, y) - 4000.0)[-1])


def _both(flc: Evaluation, aflc: Evaluation, levels: dict[str, dict[str, float]]) -> Figure:
    """Axial and contour errors of both."""
    named = {"FLC": flc, "AFLC": aflc}
    panels = {
        "axial error X [BLU]": {k: item.axes[0].motion.error for k, item in named.items()},
        "contour error [BLU]": {k: item.contour.error for k, item in named.items()},
    }
    return curves(flc.time, panels, levels)


@click.command()
@click.option("--out", type=click.Path(path_type=Path), default=Path("runs/jee-koren-2004"))
def main(out: Path) -> None:
    """Write the figures and tables into a folder and print the tables."""
    out.mkdir(parents=True, exist_ok=True)
    parts = {
        "fig-04.svg": stability,
        "fig-10.svg": circle,
        "fig-11.svg": line,
        "fig-12.svg": friction,
        "fig-15.svg": machine,
        "fig-18.svg": rule_bases,
    }
    rows = [row for name, part in parts.items() for row in part(out / name)]
    others = {"variants": variants()[0], "friction": friction_sets(), "heights": heights()}
    click.echo(write(out, [*rows, *computing()], others), nl=False)


if __name__ == "__main__":
    main()
