"""Designs of kind fuzzy-sliding for the feed drive, and LG09 Table 2."""

import numpy as np

from hfc_design.files.design import Design

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
