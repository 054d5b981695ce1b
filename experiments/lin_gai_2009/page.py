"""Figures and tables of the page of Lin & Gai 2009 (LG09); see README.md beside this file.

First hfc batch experiments/lin_gai_2009/batch.toml and the hfc compare of the page, then
python -m experiments.lin_gai_2009.page.
"""

from pathlib import Path

import click
import numpy as np

from experiments.lin_gai_2009 import pictures
from experiments.lin_gai_2009.pictures import AXES, SHOWN
from experiments.lin_gai_2009.unseen import beyond, compared, ratios
from experiments.shared import HEAD, Batch, calculated, markdown, number
from hfc_design.cli.usage import Plain
from hfc_design.plotting.files import save

CONTROLLERS = ("PID", "PID + compensation", "fuzzy sliding", "compensated")
LINEAR = ("PID of that gain", "PID of that gain + compensation")
PROGRAMS = ("corrected", "printed", "blade")
#: What a machine does as a whole.
WHOLE = {
    "contour, rms [mm]": "rms_contour_error_mm",
    "largest [mm]": "max_contour_error_mm",
    "without rapids [mm]": "cutting_max_contour_error_mm",
    "orientation, rms [deg]": "rms_orientation_error_deg",
    "largest [deg]": "max_orientation_error_deg",
    "largest velocity, of its limit": "velocity_share",
    "largest voltage [V]": "peak_voltage_V",
    "time at a limit": "limit_share",
}


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


PARTS = {
    "06": pictures.positions,
    "07": pictures.errors,
    "06-07-printed": pictures.misprint,
    "blade": pictures.blade,
}


@click.command(cls=Plain)
@click.option("--runs", default="runs/lin-gai-2009", type=click.Path(path_type=Path))
def main(runs: Path) -> None:
    """Draw the figures into the folder of the batch and print the tables."""
    batch = Batch(runs)
    machines = compared(runs.with_name(f"{runs.name}-machines") / "comparison.csv")
    for name, draw in PARTS.items():
        save(draw(batch), runs / f"fig-{name}.svg")
    parts = [
        markdown(HEAD, [*batch.published(), *endings(batch), *read_off(batch)]),
        *(each_axis(batch, name) for name in PROGRAMS),
        machine(batch),
        coupling(batch),
        ratios(machines),
        beyond(machines),
    ]
    click.echo("\n".join(parts), nl=False)


if __name__ == "__main__":
    main()
