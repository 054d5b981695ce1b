"""Random designs of every kind of an axis, and samples that go everywhere."""

import made_up
import numpy as np
from sliding import DYNAMICS, PID, sliding
from wandering import wandering

from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.runtime import Controller

ODD = (np.nan, np.inf, -np.inf, 0.0, -0.0, 1e300, -1e300, 1e-300)


def feed(**controller):
    plant = {"name": "feed-drive", "parameters": {}}
    whole = {"name": "made-up", "plant": plant, "limits": {}, "controller": controller}
    return Design.model_validate(whole)


def pd(seed, random):
    gains = dict(zip(("kp", "kd"), random.normal(0.0, 100.0, 2).tolist(), strict=True))
    return feed(kind="pd", sample_time_s=0.01, pd=gains)


def pid(seed, random):
    gains = dict(zip(("k_p", "k_i", "k_d"), random.uniform(0.0, 9.0, 3).tolist(), strict=True))
    zone = {"dead_zone": 2.0} if seed % 3 == 0 else {}
    return feed(kind="pid", sample_time_s=0.01, pid=gains, **zone)


def soc(seed, random):
    ge, gc, gu = random.uniform(0.1, 2.0, 3).tolist()
    adaptation = {"gamma": random.uniform(0.0, 1.0), "xi": random.uniform(0.0, 1.0)}
    rules = random.uniform(-3.0, 3.0, (11, 11)).tolist()
    own = {"ge": ge, "gc": gc, "gu": gu, "adaptation": adaptation, "table": rules}
    return feed(kind="soc", sample_time_s=0.01, **own)


def sliding_mode(seed, random):
    changes = {"consequents": random.uniform(-120.0, 120.0, (7, 7)).tolist()}
    changes |= {"pid": PID} if seed % 2 else {}
    learning = {"rate": random.uniform(0.0, 3.0), "largest_move": 40.0}
    learning |= {"error_dynamics": DYNAMICS} if seed % 3 == 0 else {}
    learning |= {"moves": random.uniform(-40.0, 40.0, (7, 7)).tolist()} if seed % 5 == 0 else {}
    return sliding(adaptation=learning, **changes)


def fuzzy(kind):
    def of(seed, random):
        if seed % 3 == 0:
            return made_up.with_options(kind, seed)
        if kind == "flc":
            rows, columns = random.integers(2, 12, 2).tolist()
            form = str(random.choice(["P", "PI", "PD"]))
            return made_up.fuzzy(kind, seed, rows, columns, form=form)
        return made_up.fuzzy(kind, seed)

    return of


def hierarchy(seed, random):
    inputs = int(random.integers(2, 7))
    adapting = {"k_c": 1e-2, "largest_move": 0.5, "error_scale": 3.0}
    changes = {"adaptation": adapting} if seed % 2 else {}
    made = (made_up.hierarchy, made_up.hierarchy_on_linear, made_up.scheduling)[seed % 3]
    return made(seed, inputs, **changes)


def linear(kind):
    def of(seed, random):
        found = made_up.linear(kind, seed)
        return made_up.resonating(found, seed, 2.0, 50.0) if seed % 3 == 0 else found

    return of


MADE = {
    "pd": pd,
    "pid": pid,
    "soc": soc,
    "fuzzy-sliding": sliding_mode,
    "neural": lambda seed, random: made_up.network(seed, int(random.integers(1, 30))),
    "pd+hierarchical-fuzzy": hierarchy,
    **{kind: fuzzy(kind) for kind in ("flc", "aflc", "soflc")},
    **{kind: linear(kind) for kind in ("pid+ff", "lqi")},
}


def design_of(kind, seed):
    """Every other one within a limit."""
    found = MADE[kind](seed, np.random.default_rng(seed))
    return made_up.limited(found, 30.0) if seed % 2 else found


def samples_of(design, seed):
    """Signals that wander, and now and then one that is odd."""
    found, random = wandering(design, seed, 300), np.random.default_rng(seed)
    rows = random.choice(len(found), 40, replace=False)
    found[rows, random.integers(0, found.shape[1], 40)] = random.choice(ODD, 40)
    return found


def of_the_runtime(design, samples):
    controller, names = Controller(design), list(code.signals(design))
    rows = (dict(zip(names, row, strict=True)) for row in samples.tolist())
    return np.array([controller.step(row) for row in rows])
