"""Pictures of the page of Lin & Gai 2009 (LG09); see ``page``."""

import numpy as np
from matplotlib.figure import Figure

from experiments.shared import Batch, Floats, curves

AXES = {"x": "mm", "y": "mm", "z": "mm", "a": "deg", "c": "deg"}
SHOWN = ("PID", "compensated")
ENDS = {"corrected": 0.7, "printed": 0.9}  # of what is drawn [s]; nothing moves after it
Panels = tuple[Floats, dict[str, dict[str, Floats]]]


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
