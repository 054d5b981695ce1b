"""Figures and tables of the page of Jee & Koren 2004 (JK04); see README.md beside this file.

First hfc batch experiments/jee_koren_2004/FILE for batch.toml, friction.toml and rule-bases.toml,
then python -m experiments.jee_koren_2004.page.
"""

from collections.abc import Mapping
from pathlib import Path
from time import perf_counter

import click
import numpy as np
from matplotlib.figure import Figure

from experiments.shared import HEAD, Batch, Floats, curves, markdown, number
from hfc_design.files.pairing import load_design
from hfc_design.pictures.figure import save
from hfc_design.runtime import Controller
from hfc_design.simulation.evaluation import Evaluation
from hfc_design.stability.report import stability_figure
from hfc_design.stability.stable_range import stable_range

DESIGNS = {name: f"jee-koren-2004-{name.lower()}" for name in ("FLC", "AFLC", "PID")}
CONTOUR = tuple(f"cycle_{k}_rms_contour_error_BLU" for k in (1, 2, 3))
AXIAL = tuple(f"cycle_{k}_x_rms_error_BLU" for k in (1, 2, 3))
LARGEST, UNREST = "cycle_3_max_contour_error_BLU", "cycle_3_rms_command_change"
STEP = 20.0  # of step.toml [BLU]


def stability(out: Path) -> list[list[str]]:
    """Fig. 4: the stable range. The paper prints the curve; the numbers are its equations'."""
    found = stable_range(28.3, 0.055, 0.01)
    save(stability_figure(found, {"rule base I at its centres": (32.0 / 21.0, 16.0 / 3.0)}), out)
    equations = "its equations, evaluated independently; the paper prints a curve only"
    linear = "where the linear loop u = K_1 e becomes unstable"
    return [
        calculated("4", "K_1, eq. 21 as printed [unit/BLU]", 9.0364, found.k1_printed, equations),
        calculated("4", "K_2 at K_1 = 4.518, eq. 22 [unit/BLU]", 5.895, float(found.k2(4.518)),
                   equations),
        calculated("4", "K_1 that this project allows [unit/BLU]", None, found.k1_bound, linear),
        calculated("4", "K_1, eq. 21 with the right sign [unit/BLU]", None,
                   found.k1_theorem),
    ]  # fmt: skip


def computing() -> list[list[str]]:
    """Section 6: time that one axis takes in a sample, here of the runtime in Python."""
    rows = []
    for name, published in (("AFLC", 0.4), ("FLC", 0.3)):
        controller = Controller(load_design(DESIGNS[name]))
        errors = np.round(20.0 * np.sin(0.01 * np.arange(2000))).tolist()
        begun = perf_counter()
        for error in errors:
            controller.step({"error": error})
        time = 1e3 * (perf_counter() - begun) / len(errors)
        here = "a 486 at 33 MHz there, Python here"
        rows.append(calculated("6", f"{name}: time of a sample [ms]", published, time, here))
    return rows


def calculated(
    figure: str, quantity: str, published: float | None, found: float, remark: str = ""
) -> list[str]:
    """A row of ``HEAD`` that no run stands behind."""
    ratio = None if published is None else found / published
    told = (number(published), number(found), number(ratio, ".2f"))
    return [figure, quantity, *told, remark]


def circle(batch: Batch) -> Figure:
    """Fig. 10: circle of 40 mm, three cycles."""
    found = {name: batch.motion(name) for name in ("FLC", "AFLC")}
    return errors(found, {"axial error X [BLU]": {"RMS of the FLC in the paper": 16.2}})


def line(batch: Batch) -> Figure:
    """Fig. 11: line at 26.6 deg."""
    found = {name: batch.motion(f"line, {name}") for name in ("FLC", "AFLC")}
    return errors(found, {"contour error [BLU]": {"FLC in the paper": 5.0}})


def errors(found: Mapping[str, Evaluation], levels: Mapping[str, Mapping[str, float]]) -> Figure:
    """Axial and contour errors."""
    panels = {
        "axial error X [BLU]": {k: item.axes[0].motion.error for k, item in found.items()},
        "contour error [BLU]": {k: item.contour.error for k, item in found.items()},
    }
    return curves(found["FLC"].time, panels, levels)


def friction(batch: Batch) -> Figure:
    """Fig. 12: circle of 20 mm with and without friction; the third cycle."""
    kinds = {"F_c = 15": "F_c = 15", "eq. 28 alone": "eq. 28", "no friction": "no friction"}
    panels: dict[str, dict[str, Floats]] = {}
    for name in ("AFLC", "PID"):
        panel = panels[f"contour error, {name} [BLU]"] = {}
        for told, kind in kinds.items():
            tuned = ", K_I = 8" if name == "AFLC" and kind != "no friction" else ""
            found = batch.motion(f"slow circle, {name}, {kind}{tuned}")
            last = found.time >= 40.0
            panel[told] = found.contour.error[last]
    levels = {"contour error, PID [BLU]": {"PID in the paper": 15.6}}
    return curves(found.time[last], panels, levels)


def slot(batch: Batch) -> Figure:
    """Fig. 15: slotting."""
    found = batch.motion("slot, AFLC")
    return curves(found.time, {"contour error [BLU]": {"AFLC in a slot": found.contour.error}})


def steps(batch: Batch) -> Figure:
    """Fig. 18: step responses of the rule bases."""
    names = [f"rule base {base}" for base in ("I", "II", "III")]
    found = {name: batch.motion(f"step, {name}") for name in names}
    position = {name: item.axes[0].motion.state.position for name, item in found.items()}
    label = "position [BLU]"
    return curves(found[names[0]].time, {label: position}, {label: {"reference": STEP}})


def variants(batch: Batch) -> str:
    """What each setting does to fig. 10."""
    labels = [run.settings["label"] for run in batch.runs]
    (fixed,) = batch.values("FLC", CONTOUR[-1])
    lines = []
    for label in labels[labels.index("FLC") :]:
        *rms, largest, unrest = batch.values(label, *AXIAL, *CONTOUR, LARGEST, UNREST)
        forms = (*[".1f"] * 3, *[".2f"] * 3)
        told = [number(value, form) for value, form in zip(rms, forms, strict=True)]
        factor = fixed / rms[-1]
        lines.append([label, *told, f"{largest:.1f}", f"{unrest:.1f}", f"{factor:.1f}"])
    head = ("AFLC on the circle of fig. 10", "axial 1", "2", "3", "contour 1", "2", "3",
            "largest", "unrest", "FLC / AFLC")  # fmt: skip
    return markdown(head, lines)


def friction_sets(batch: Batch) -> str:
    """What gain and friction do to the figures that have numbers."""
    lines = [["the paper", "", "", "16.2", "3.4", "15.6", "1.5", "5.6", "4", "1.5"]]
    keys = [f"plant.parameters.{key}" for key in ("gain", "coulomb", "stiction_rise")]
    sets = dict.fromkeys(
        tuple(run.settings[key] for key in keys) for run in batch.runs if keys[1] in run.settings
    )
    for own in sets:
        machine = dict(zip(keys, own, strict=True))

        def of(name: str, scenario: str, machine: dict[str, float] = machine) -> dict[str, float]:
            where = {"design": DESIGNS[name], "scenario": f"{scenario}.toml"}
            return batch.run(**where, **machine).score

        flc, aflc = of("FLC", "circle"), of("AFLC", "circle")
        pid, slow = of("PID", "slow-circle"), of("AFLC", "slow-circle")
        easy = of("PID", "slow-circle-frictionless", {keys[0]: own[0]})
        follows = flc[AXIAL[-1]] < 100.0  # else the largest singleton is too small
        contour = CONTOUR[-1]
        lines.append([
            *(f"{value:g}" for value in own),
            f"{flc[AXIAL[-1]]:.3g}" if follows else "cannot follow",
            *(f"{value:.3g}" for value in (pid[contour], pid[LARGEST], easy[contour])),
            f"{aflc[AXIAL[-1]]:.3g}",
            f"{flc[contour] / aflc[contour]:.2f}" if follows else "–",
            f"{slow[contour]:.3g}",
        ])  # fmt: skip
    head = ("K", "F_c", "rise", "FLC axial", "PID contour", "PID largest", "PID, no friction",
            "AFLC axial", "FLC / AFLC", "AFLC, fig. 12a")  # fmt: skip
    return markdown(head, lines)


def heights(batch: Batch) -> str:
    """Integral of the error's magnitude of the steps of fig. 18, by gain, friction and height."""
    keys = ("plant.parameters.gain", "scenario", "reference.height")
    cases = sorted({tuple(run.settings[key] for key in keys) for run in batch.runs},
                   key=lambda case: (case[0], case[1] != "step.toml", case[2]))  # fmt: skip
    lines = []
    for gain, scenario, height in cases:
        own = dict(zip(keys, (gain, scenario, height), strict=True))
        runs = (batch.run(design=name, **own)
                for name in (DESIGNS["FLC"], "base-2.json", "base-3.json"))  # fmt: skip
        words = "none" if scenario == "step.toml" else "eq. 28"
        areas = (f"{run.score['iae_BLU_s']:.2f}" for run in runs)
        lines.append([f"{gain:g}", words, f"{height:g}", *areas])
    return markdown(("K", "friction", "height [BLU]", "I", "II", "III"), lines)


@click.command()
@click.option("--runs", default="runs/jee-koren-2004", type=click.Path(path_type=Path))
def main(runs: Path) -> None:
    """Draw the figures into the folder of the batch and print the tables."""
    batch = Batch(runs)
    parts = {"10": circle, "11": line, "12": friction, "15": slot, "18": steps}
    for name, draw in parts.items():
        save(draw(batch), runs / f"fig-{name}.svg")
    rows = [*stability(runs / "fig-04.svg"), *batch.published(), *computing()]
    click.echo(markdown(HEAD, rows))
    click.echo(variants(batch))
    click.echo(friction_sets(Batch(runs.with_name(f"{runs.name}-friction"))))
    click.echo(heights(Batch(runs.with_name(f"{runs.name}-rule-bases"))), nl=False)


if __name__ == "__main__":
    main()
