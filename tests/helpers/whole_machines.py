"""Controllers of a whole machine of two feed drives, and what happens to it."""

import made_up
import numpy as np
from sliding import EVERY

import hfc_design.api as hfc
from hfc_design.controllers.controller import PathView
from hfc_design.files.design import Design
from hfc_design.motion.contour import local_error
from hfc_design.runtime import Machine

PID = {"kind": "pid", "pid": {"k_p": 3.0, "k_i": 20.0, "k_d": 0.02}}
AHEAD = {"feed_forward": {"x": 0.03, "y": 0.04}}


def record_of(design):
    return design.controller.model_dump(mode="json")


def machine(name, controller, limits=None):
    data = hfc.load_design("jee-koren-2004-pid").model_dump(mode="json")
    data["plant"] = {"name": "feed-drive", "parameters": {}, "axes": {"x": {}, "y": {}}}
    own = {"sample_time_s": 0.01, **controller}
    return Design.model_validate(data | {"name": name, "controller": own, "limits": limits or {}})


def coupled(inner, **changes):
    contour = {"k_p": 2.0, "k_i": 30.0, "k_d": 0.01}
    return {"kind": "cross-coupled", "inner": inner, "contour": contour} | changes


def compensated(inner):
    own = {"k_p": {"x": 2.0, "y": 3.0}, "dead_zone": 4.0, "programmed_speed": 700.0}
    return {"kind": "dynamic-compensation", "inner": inner, **own}


AFLC = record_of(hfc.load_design("jee-koren-2004-aflc"))
SOFLC = record_of(hfc.load_design("jee-koren-1995-soflc")) | {"integral_gain": 3.0}
NETWORK = record_of(made_up.network(2, 5))
SLIDING = record_of(EVERY["beside a pid within a limit"])
UNLIKE = {"kind": "per-axis", "axes": {"x": AFLC, "y": NETWORK}}
DESIGNS = {
    "pid": machine("coupled", coupled(PID), {"command": 60.0}),
    "limits": machine(
        "coupled", coupled(PID, **AHEAD), {"axes": {"x": {"command": 20.0}, "y": {}}}
    ),
    "both learn": machine("coupled", coupled(AFLC, **AHEAD)),
    "one learns": machine("one", coupled({"kind": "per-axis", "axes": {"x": SOFLC, "y": PID}})),
    "unlike": machine("unlike", coupled(UNLIKE), {"command": 90.0}),
    "compensated": machine("outer", compensated(PID), {"command": 60.0}),
    "sliding": machine("sliding", compensated(SLIDING), {"command": 60.0}),
    "slow": machine("slow", coupled(PID), {"command": 60.0, "command_rate": 400.0}),
    "slow and learns": machine(
        "nested_slow",
        compensated(coupled(AFLC)),
        {"axes": {"x": {"command_rate": 2000.0}, "y": {}}},
    ),
    "nested": machine("nested", compensated(coupled(UNLIKE, **AHEAD))),
}


def random_machine(seed):
    """Any controllers inside, alike or not, under either of the outer ones or both."""
    random = np.random.default_rng(seed)
    gains = random.uniform(0.0, 5.0, 3).tolist()
    pid = {"kind": "pid", "pid": dict(zip(("k_p", "k_i", "k_d"), gains, strict=True))}
    inside = [pid, AFLC, SOFLC, SLIDING, record_of(made_up.network(seed, 1 + seed % 5))]
    one, other = (inside[k] for k in random.integers(0, len(inside), 2))
    inner = {"kind": "per-axis", "axes": {"x": one, "y": other}} if seed % 2 else one
    if seed % 3 == 0:
        ahead = {"x": float(random.normal()), "y": float(random.normal())}
        inner = coupled(inner, **({"feed_forward": ahead} if seed % 2 else {}))
    elif seed % 3 == 1:
        inner = compensated(inner)
    else:
        inner = compensated(coupled(inner))
    limits = {"command": float(random.uniform(20.0, 90.0))} if seed % 4 else {}
    limits |= {"command_rate": float(random.uniform(500.0, 5000.0))} if seed % 5 == 0 else {}
    return machine(f"machine_{seed}", inner, limits)


def happenings(design, count=600):
    """Of each sample the signals of both axes, and the path, which bends to both sides."""
    random = np.random.default_rng(5)
    errors = random.normal(0.0, 1.0, (count, 2)).cumsum(axis=0)
    errors[200:220] = 0.0
    rates = 500.0 * np.sin(np.arange(2 * count).reshape(-1, 2) / 40.0)
    angle = np.arange(count) / 30.0
    curvature = np.where(np.arange(count) < 400, 0.002, -0.001)
    found = []
    for k in range(count):
        told = {}
        for axis, e, r in zip("xy", errors[k], rates[k], strict=True):
            told[axis] = {"error": float(e), "reference_rate": float(r), "velocity": float(r) + 3.0}
            told[axis]["error_rate"] = 2.0 * told[axis]["error"] - 0.1 * told[axis]["velocity"]
        tangent, bent = (float(np.cos(angle[k])), float(np.sin(angle[k]))), float(curvature[k])
        off = local_error(-errors[k][0], -errors[k][1], *tangent, bent)
        found.append((told, PathView(tangent, bent, float(off))))
    return found


def in_c(design, samples):
    """The same as the program reads it."""
    names = design.kind.reads(design.controller)
    rows = [
        [told[axis][name] for axis in "xy" for name in names]
        + [*path.tangent, path.curvature, path.contour_error]
        for told, path in samples
    ]
    return np.array(rows)


def of_the_runtime(design, samples):
    controller = Machine(design, ("x", "y"))
    steps = [controller.step(told, path) for told, path in samples]
    return controller, np.array([[step["x"], step["y"]] for step in steps])
