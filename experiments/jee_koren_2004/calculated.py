"""Figures of Jee & Koren 2004 (JK04) that no run stands behind: equations, rule tables, a time."""

from collections.abc import Mapping
from pathlib import Path
from time import perf_counter

import numpy as np

from experiments.jee_koren_2004.pictures import derivative_parts
from experiments.shared import calculated
from hfc_design.files.loop_setup import load_design
from hfc_design.plotting.files import save
from hfc_design.runtime import Controller
from hfc_design.stability.report import stability_figure
from hfc_design.stability.stable_range import stable_range


def stability(out: Path) -> list[list[str]]:
    """Fig. 4: the stable range. The paper prints the curve; the numbers are its equations'."""
    found = stable_range(28.3, 0.055, 0.01)
    points = {"rule base I at its centres": (32.0 / 21.0, 16.0 / 3.0)}
    points["the same, doubled"] = (64.0 / 21.0, 32.0 / 3.0)
    save(stability_figure(found, points), out)
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


def rule_bases(places: Mapping[str, str]) -> list[list[str]]:
    """Fig. 17 as numbers, at the centres of the terms of E_0 to E_3."""
    words = {"I": "the lowest in the paper", "II": "", "III": "intermediate in the paper"}
    gains = {}
    for base, design in places.items():
        changes, parts = derivative_parts(design)
        gains[base] = parts[:, changes != 0.0] / changes[changes != 0.0]  # NL to PL without ZR
    told = [
        (f"base {base}: mean derivative gain [unit/BLU]", None, float(own.mean()), words[base])
        for base, own in gains.items()
    ]
    zero = "excessively low (zero) in the paper"
    at_ps = float(gains["III"][1:3, 3].max())
    told += [
        ("base III: gain of PS and PM for a change PS [unit/BLU]", 0.0, at_ps, zero),
        ("base I: largest derivative gain [unit/BLU]", 8.0 / 1.5, gains["I"].max(), "eq. 23"),
    ]
    return [calculated("17", *row) for row in told]


def computing() -> list[list[str]]:
    """Section 6: time that one axis takes in a sample, here of the runtime in Python."""
    rows = []
    for name, published in (("AFLC", 0.4), ("FLC", 0.3)):
        controller = Controller(load_design(f"jee-koren-2004-{name.lower()}"))
        errors = np.round(20.0 * np.sin(0.01 * np.arange(2000))).tolist()
        begun = perf_counter()
        for error in errors:
            controller.step({"error": error})
        time = 1e3 * (perf_counter() - begun) / len(errors)
        here = "a 486 at 33 MHz there, Python here"
        rows.append(calculated("6", f"{name}: time of a sample [ms]", published, time, here))
    return rows
