"""What ``hfc stability`` says: the range as plain data and as a table."""

from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from hfc_design.stability import StableRange, theorem_k1

#: K_2 bounds are told at these shares of the largest K_1.
SHARES = (0.1, 0.3, 0.5, 0.7, 0.9)


def numbers(found: StableRange) -> dict[str, Any]:
    """The range as plain data, gains in unit/BLU."""
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
    }


def show(found: StableRange) -> None:
    """Print the numbers as a table."""
    table = Table(caption="gains in unit/BLU", caption_justify="left")
    table.add_column("stable range, JK04 section 3", no_wrap=True)
    table.add_column("value", justify="right")
    data = numbers(found)
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
    Console().print(table)
