"""Figures and tables of the page of Lin & Gai 2009 (LG09); see README.md beside this file.

First hfc batch experiments/lin_gai_2009/batch.toml and the hfc compare of the page, then
python -m experiments.lin_gai_2009.page.
"""

import csv
from pathlib import Path

import click
import numpy as np
from matplotlib.figure import Figure

from experiments.shared import HEAD, Batch, Floats, calculated, curves, markdown, number
from hfc_design.pictures.figure import save

AXES = {"x": "mm", "y": "mm", "z": "mm", "a": "deg", "c": "deg"}
CONTROLLERS = ("PID", "PID + compensation", "fuzzy sliding", "compensated")
LINEAR = ("PID of that gain", "PID of that gain + compensation")
PROGRAMS = ("corrected", "printed", "blade")
SHOWN = ("PID", "compensated")
ENDS = {"corrected": 0.7, "printed": 0.9}  # of what is drawn [s]; nothing moves after it
Panels = tuple[Floats, dict[str, dict[str, Floats]]]
#: What a machine does as a whole.
WHOLE = {
    "contour, rms [mm]": "rms_contour_error_mm",
    "largest [mm]": "max_contour_error_mm",
    "orientation, rms [deg]": "rms_orientation_error_deg",
    "largest [deg]": "max_orientation_error_deg",
    "largest velocity, of its limit": "velocity_share",
    "largest voltage [V]": "peak_voltage_V",
    "time at a limit": "limit_share",
}
#: Of the unseen machines.
MACHINES = {
    "contour, rms": "rms_contour_error_mm",
    "largest": "max_contour_error_mm",
    "orientation, rms": "rms_orientation_error_deg",
    "Z, largest": "z_max_error_mm",
    "C, largest": "c_max_error_deg",
    "chatter": "rms_voltage_change_V",
}


def along(batch: Batch, name: str, axes: str, errors: bool) -> Panels:
    """Positions or errors of ``axes`` through a program, of every second sample."""
    found = {told: batch.motion(f"{name}, {told}") for told in SHOWN}
    time = found["PID"].time
    part = np.arange(0, np.searchsorted(time, ENDS[name]), 2)
    panels: dict[str, dict[str, Floats]] = {}
    for axis in axes:
        own = {told: item.axes[[*AXES].index(axis)] for told, item in found.items()}
        label = f"{axis.upper()} [{AXES[axis]}]"
        if errors:
            panel = {told: item.motion.error[part] for told, item in own.items()}
            panels[f"error {label}"] = panel
        else:
            panel = {told: item.motion.state.position[part] for told, item in own.items()}
            panels[label] = panel | {"reference": own["PID"].reference[part]}
    return time[part], panels


def positions(batch: Batch) -> Figure:
    """Fig. 6: where each axis is, on the corrected program."""
    return curves(*along(batch, "corrected", "xyzac", errors=False))


def errors(batch: Batch) -> Figure:
    """Fig. 7: the tracking error of each axis, on the corrected program."""
    return curves(*along(batch, "corrected", "xyzac", errors=True))


def misprint(batch: Batch) -> Figure:
    """Figs. 6 and 7, C on the program as it is printed."""
    time, places = along(batch, "printed", "c", errors=False)
    return curves(time, places | along(batch, "printed", "c", errors=True)[1])


def blade(batch: Batch) -> Figure:
    """Contour and orientation on the program that nobody tuned for."""
    found = {told: batch.motion(f"blade, {told}") for told in SHOWN}
    panels = {
        "contour error [mm]": {told: item.contour.error for told, item in found.items()},
        "orientation [deg]": {told: item.contour.turned for told, item in found.items()},
    }
    return curves(found["PID"].time, panels)


def endings(batch: Batch) -> list[list[str]]:
    """Fig. 6 says that both controllers end at nearly the same place."""
    found = {told: batch.motion(f"corrected, {told}") for told in SHOWN}
    rows = []
    for k, (axis, unit) in enumerate(AXES.items()):
        own, other = (found[told].axes[k].motion.state.position[-1] for told in SHOWN[::-1])
        quantity = f"{axis.upper()}: where it ends, compensated less PID [{unit}]"
        rows.append(calculated("6", quantity, 0.0, own - other, '"nearly identical"'))
    return rows


def read_off(batch: Batch) -> list[list[str]]:
    """Fig. 4: the speed of F10000 that is reached, and how far X and C have to go."""
    rows = []
    for name in ("printed", "corrected"):
        axes = batch.motion(f"{name}, PID").axes
        rates = [axis.happens.reference_rate for axis in axes[:3]]
        fastest = 60.0 * float(np.linalg.norm(rates, axis=0).max())
        remark = f"{name} program"
        rows.append(calculated("4", "largest speed [mm/min]", 10000.0, fastest, remark))
        for k, told in ((0, "X [mm]"), (4, "C [deg]")):
            way = float(np.abs(np.diff(axes[k].reference)).sum())
            rows.append(calculated("4", f"way of {told}", None, way, remark))
    return rows


def each_axis(batch: Batch, name: str) -> str:
    """Errors of every axis under every controller on one program."""
    header = [f"{axis.upper()} [{unit}]" for axis, unit in AXES.items()]
    lines = []
    for told in (*CONTROLLERS, *LINEAR):
        for what, label in (
            ("rms_error", "rms"),
            ("max_error", "largest"),
            ("overshoot", "overshoot"),
        ):
            keys = [f"{axis}_{what}_{unit}" for axis, unit in AXES.items()]
            found = batch.values(f"{name}, {told}", *keys)
            lines.append([told, label, *map(number, found)])
    return markdown([name, "", *header], lines)


def machine(batch: Batch) -> str:
    """Every controller on every program, alone and with axes that feel each other."""
    lines = []
    for before in ("", "coupled, "):
        for name in PROGRAMS:
            for told in CONTROLLERS if before else (*CONTROLLERS, *LINEAR):
                label = f"{before}{name}, {told}"
                lines.append([label, *map(number, batch.values(label, *WHOLE.values()))])
    return markdown(["program, controller", *WHOLE], lines)


def coupling(batch: Batch) -> str:
    """What it does to the errors of the axes that it reaches."""
    keys = (
        "z_max_error_mm",
        "z_overshoot_mm",
        "a_max_error_deg",
        "c_max_error_deg",
        "c_overshoot_deg",
    )
    head = (
        "coupled",
        "Z, largest [mm]",
        "overshoot",
        "A, largest [deg]",
        "C, largest [deg]",
        "overshoot",
    )
    labels = [f"{name}, {told}" for name in PROGRAMS for told in SHOWN]
    lines = [[label, *map(number, batch.values(f"coupled, {label}", *keys))] for label in labels]
    return markdown(head, lines)


def unseen(path: Path) -> str:
    """The controller of the paper over every other, machine by machine, of ``hfc compare``."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["machine"] != "0"]  # the nominal one
    found: dict[tuple[str, str], list[dict[str, str]]] = {}
    for row in rows:
        found.setdefault((row["motion"], row["design"]), []).append(row)
    motions, designs = (list(dict.fromkeys(names)) for names in zip(*found, strict=True))
    lines = []
    for motion in motions:
        own = found[motion, designs[0]]
        for other in designs[1:]:
            line = [motion, other]
            for key in MACHINES.values():
                pairs = zip(own, found[motion, other], strict=True)
                ratios = np.array([float(one[key]) / float(two[key]) for one, two in pairs])
                line.append(f"{np.median(ratios):.2f} ({(ratios < 1.0).sum()})")
            lines.append(line)
    return markdown(["scenario", "compensated over", *MACHINES], lines)


PARTS = {"06": positions, "07": errors, "06-07-printed": misprint, "blade": blade}


@click.command()
@click.option("--runs", default="runs/lin-gai-2009", type=click.Path(path_type=Path))
def main(runs: Path) -> None:
    """Draw the figures into the folder of the batch and print the tables."""
    batch = Batch(runs)
    for name, draw in PARTS.items():
        save(draw(batch), runs / f"fig-{name}.svg")
    parts = [
        markdown(HEAD, [*batch.published(), *endings(batch), *read_off(batch)]),
        *(each_axis(batch, name) for name in PROGRAMS),
        machine(batch),
        coupling(batch),
        unseen(runs.with_name(f"{runs.name}-machines") / "comparison.csv"),
    ]
    click.echo("\n".join(parts), nl=False)


if __name__ == "__main__":
    main()
