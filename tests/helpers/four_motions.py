"""A scenario of four motions."""

#: Four motions of different lengths, one with a load, one with a start of its own.
MOTIONS = [
    {"name": "ramp", "duration_s": 0.3},
    {"name": "creep", "reference": {"kind": "ramp", "velocity": 0.002}, "weight": 2.0},
    {"name": "cut", "duration_s": 0.15, "load": {"constant": 5.0}, "settled_after_s": 0.1},
    {
        "name": "step",
        "duration_s": 0.1,
        "reference": {"kind": "step", "height": 0.01},
        "start": {"spindle_angle": 0.001, "rotor_angle": 0.001},
    },
]
SEVERAL = {"name": "several", "simulation": {"duration_s": 0.2}, "motions": MOTIONS}
