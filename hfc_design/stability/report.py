"""What ``hfc stability`` says: the range as plain data and as a table."""

from collections.abc import Mapping, Sequence

import numpy as np
from rich.table import Table

from hfc_design.core.console import terminal
from hfc_design.core.records import UserError
from hfc_design.core.shapes import Json
from hfc_design.stability.stable_range import StableRange, theorem_k1

#: K_2 bounds are told at these shares of the largest K_1.
SHARES = (0.1, 0.3, 0.5, 0.7, 0.9)
#: (K_1, K_2) of rule tables [unit/BLU], by how they were found.
Points = Mapping[str, tuple[float, float]]


def drive_of(
    told: str, linear: Sequence[tuple[float, float]], every: float, given: Mapping[str, float]
) -> dict[str, float]:
    """Arguments of ``stable_range``: what is ``given``, else the design's own.

    ``told`` says what the design is for; ``linear`` has K and tau of each axis, () where there is
    none; that with the largest gain counts. ``every`` is the sample time [s].

    Raises:
        UserError: the plant is no feed drive, and gain or time constant are not given.
    """
    own = {"sample_time": every}
    if linear:
        gain, time_constant = max(linear)
        own |= {"gain": gain, "time_constant": time_constant}
    found = own | dict(given)
    if not {"gain", "time_constant"} <= found.keys():
        raise UserError(f"{told}, no feed drive: give --gain and --time-constant of its drive")
    return found


def numbers(found: StableRange, points: Points) -> Json:
    """The range and ``points`` in it as plain data, gains in unit/BLU."""
    k1 = found.k1 * np.array(SHARES)
    return {
        **found.drive._asdict(),
        "k1_bound": found.k1,
        "k1_printed": found.k1_printed,
        "k1_linear": found.k1_linear,
        "k1_theorem": theorem_k1(found.drive),
        "k2_bounds": [
            {"k1": float(x), "k2": float(y)} for x, y in zip(k1, found.k2(k1), strict=True)
        ],
        "points": {
            name: {"k1": x, "k2": y, "inside": bool(found.contains(x, y))}
            for name, (x, y) in points.items()
        },
    }


def show(found: StableRange, points: Points) -> None:
    """Print the numbers as a table."""
    table = Table(caption="gains in unit/BLU", caption_justify="left")
    table.add_column("stable range, JK04 section 3", no_wrap=True)
    table.add_column("value", justify="right")
    data = numbers(found, points)
    rows = {
        "K_0 [BLU/unit]": data["k0"],
        "a": data["a"],
        "b": data["b"],
        "K_1 below, the range": data["k1_bound"],
        "K_1 below, eq. 21 as printed": data["k1_printed"],
        "K_1 below, linear loop": data["k1_linear"],
        "K_1 below, eq. 21, sign corrected": data["k1_theorem"],
        **{f"K_2 below, at K_1 = {p['k1']:.5g}": p["k2"] for p in data["k2_bounds"]},
    }
    for name, value in rows.items():
        table.add_row(name, f"{value:.6g}")
    for name, point in data["points"].items():
        where = "inside" if point["inside"] else "outside"
        table.add_row(f"{name}: K_1, K_2", f"{point['k1']:.4g}, {point['k2']:.4g} {where}")
    terminal().print(table)
