"""A program for five axes that start at 0."""

import hfc_design.api as hfc


def five_axes(folder, text, *changes):
    """The scenario of a program, which is written into ``folder``."""
    (folder / "part.ngc").write_text(text)
    limits = {axis: {"acceleration_per_s2": 800.0} for axis in "xyzac"}
    data = {
        "plant": {"name": "five-axis"},
        "reference": {"kind": "gcode", "file": str(folder / "part.ngc"), "limits": limits},
        "simulation": {"duration_s": 1.0, "sample_time_s": 0.002},
        "limits": {"command": 8.0},
        "controller": {"kind": "pid"},
    }
    return hfc.load_scenario(data, list(changes))
