"""Designs of kind fuzzy-sliding for the feed drive, and LG09 Table 2."""

import numpy as np

from hfc_design.files.design import Design
from hfc_design.runtime import Controller

#: As printed: rows are the error LP to LN, columns its rate LN to LP.
PRINTED = """
LP LP LP LP LP LP LP
SP SP SP MP MP LP LP
ZZ SP SP SP MP MP LP
ZZ ZZ ZZ ZZ ZZ ZZ ZZ
LN MN MN SN SN SN ZZ
LN LN MN MN SN SN SN
LN LN LN LN LN LN LN
"""
HEIGHTS = {"LN": -3, "MN": -2, "SN": -1, "ZZ": 0, "SP": 1, "MP": 2, "LP": 3}
#: (7, 7) rows and columns LN to LP, in shares of LP.
TABLE_2 = np.array([[HEIGHTS[x] for x in row.split()] for row in PRINTED.split("\n")[-2:0:-1]]) / 3


def table(height=120.0):
    return (height * TABLE_2).tolist()


def sliding(limit=None, **changes):
    """Of a feed drive; ``changes`` are of the controller."""
    controller = {
        "kind": "fuzzy-sliding",
        "sample_time_s": 0.01,
        "largest_error": 60.0,
        "largest_error_rate": 2000.0,
        "consequents": table(),
        "sliding": {"slope": 20.0, "gain": 10.0, "boundary_layer": 300.0},
        "adaptation": {"rate": 2.0, "largest_move": 40.0},
    }
    whole = {"name": "sliding", "plant": {"name": "feed-drive", "parameters": {}}}
    whole["limits"] = {"command": limit} if limit else {}
    return Design.model_validate({**whole, "controller": controller | changes})


PID = {"k_p": 1.5, "k_i": 8.0, "k_d": 0.02}
#: P_2 = (12.5, 0.7): by hand, p_12 = q_1 / (2 k_1), p_22 = (q_2 + 2 p_12) / (2 k_2).
DYNAMICS = {"gains": [400.0, 40.0], "weights": [[10_000.0, 0.0], [0.0, 31.0]]}
EVERY = {
    "alone": sliding(),
    "within a limit": sliding(100.0),
    "beside a pid": sliding(pid=PID),
    "beside a pid within a limit": sliding(60.0, pid=PID),
    "with a Q of its own": sliding(
        100.0,
        adaptation={"rate": 0.2, "largest_move": 40.0, "error_dynamics": DYNAMICS},
    ),
    "with what it learnt": sliding(
        100.0,
        adaptation={
            "rate": 2.0,
            "largest_move": 40.0,
            "moves": np.random.default_rng(4).uniform(-40.0, 40.0, (7, 7)).tolist(),
        },
    ),
}


def wandering(count=3000):
    """Errors and rates all over the table and beyond it, with rests, jumps and whole numbers."""
    random = np.random.default_rng(0)
    k = np.arange(count)
    error = 50.0 * np.sin(k / 40.0) + random.normal(0.0, 3.0, count)
    rate = 1500.0 * np.cos(k / 40.0) + random.normal(0.0, 200.0, count)
    error[1000:1100], rate[1000:1100] = 0.0, 0.0
    error[2000:] = np.round(error[2000:])
    error[::50] *= 3.0
    corners = [[20.0 * i, 2000.0 / 3.0 * j] for i in range(-4, 5) for j in range(-4, 5)]
    far = [[x, y] for x in (1.7e308, -1.7e308, 0.0, 1e-300) for y in (1e300, -1e300, 0.0)]
    return np.array([*np.stack([error, rate], axis=1), *corners, *far, [1.0, 1.0]])


def of_the_runtime(design, samples):
    controller = Controller(design)
    rows = (dict(zip(("error", "error_rate"), row, strict=True)) for row in samples.tolist())
    return np.array([controller.step(row) for row in rows])
