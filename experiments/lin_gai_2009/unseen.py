"""Tables of what ``hfc compare`` found on unseen machines; see ``page``."""

import csv
from pathlib import Path

import click
import numpy as np

from experiments.lin_gai_2009.pictures import AXES
from experiments.shared import markdown, number

#: Motion and design -> a row for each machine.
Machines = dict[tuple[str, str], list[dict[str, str]]]
UNSEEN = {
    "contour, rms": "rms_contour_error_mm",
    "largest": "max_contour_error_mm",
    "orientation, rms": "rms_orientation_error_deg",
    "Z, largest": "z_max_error_mm",
    "C, largest": "c_max_error_deg",
    "chatter": "rms_voltage_change_V",
}


def compared(path: Path) -> Machines:
    """What ``hfc compare`` wrote of every machine but the nominal one."""
    if not path.exists():
        raise click.UsageError(f"{path}: is not there; run the hfc compare of the page first")
    with path.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["machine"] != "0"]
    found: Machines = {}
    for row in rows:
        found.setdefault((row["motion"], row["design"]), []).append(row)
    return found


def ratios(found: Machines) -> str:
    """The controller of the paper over every other, machine by machine."""
    motions, designs = (list(dict.fromkeys(names)) for names in zip(*found, strict=True))
    lines = []
    for motion in motions:
        own = found[motion, designs[0]]
        for other in designs[1:]:
            line = [motion, other]
            for key in UNSEEN.values():
                pairs = zip(own, found[motion, other], strict=True)
                shares = np.array([float(one[key]) / float(two[key]) for one, two in pairs])
                line.append(f"{np.median(shares):.2f} ({(shares < 1.0).sum()})")
            lines.append(line)
    return markdown(["scenario", "compensated over", *UNSEEN], lines)


def beyond(found: Machines) -> str:
    """On how many machines an axis overshoots, and how far at most."""
    lines = []
    for (motion, design), rows in found.items():
        far = np.array(
            [
                [float(row[f"{axis}_overshoot_{unit}"]) for axis, unit in AXES.items()]
                for row in rows
            ]
        )
        count = (far > 0.0).any(axis=1).sum()
        lines.append(
            [motion, design, str(count), number(far[:, :3].max()), number(far[:, 3:].max())]
        )
    head = ["scenario", "controller", "machines that overshoot", "most [mm]", "most [deg]"]
    return markdown(head, lines)
