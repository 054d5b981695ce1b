"""Designs that Structured Text holds, and inputs on which a block of it is compared."""

from itertools import product

import made_up
import numpy as np
from sliding import EVERY
from wiring import design, silent

from hfc_design.controllers.flc.record import CompensationRecord
from hfc_design.files.design import Design, Limits, builtin_designs, named_design

LOW = CompensationRecord(
    forward=(0.5, -2.0, 3.0),
    backward=(-0.4, -1.5, -2.5),
    highest_velocity_mm_s=2.0,
    breakaway=(4.0, -5.0),
    smallest_error=1.5,
)


def updated(name, **changes):
    """A built-in design with other keys of its controller."""
    data = named_design(name).model_dump(mode="json")
    data["controller"] |= changes
    return Design.model_validate(data)


def slow(name, command, rate):
    limits = Limits(command=command, command_rate=rate)
    return named_design(name).model_copy(update={"limits": limits})


#: What is written.
CASES = {
    "pd": named_design("pd-only"),
    "pid": named_design("jee-koren-2004-pid"),
    "pid whose command is slow": slow("jee-koren-2004-pid", 60.0, 400.0),
    "hierarchy whose command is slow": slow("lin-lee-1999-table-1", 60.0, 9e3),
    "pid with a dead zone": updated("jee-koren-2004-pid", dead_zone=2.0),
    "flc of 5 x 3": made_up.named(1, 5, 3),
    "flc of 2 x 11": made_up.named(1, 2, 11),
    "flc with a dead zone": made_up.with_options("flc", 3),
    "aflc with a dead zone": updated("jee-koren-2004-aflc", dead_zone=2.0),
    "pid+ff": made_up.linear("pid+ff", 1),
    "lqi within a limit": made_up.limited(made_up.linear("lqi", 2), 400.0),
    "lqr of a feed drive": made_up.linear("lqr", 3, "feed-drive"),
    "table 1": named_design("lin-lee-1999-table-1"),
    "table 2": named_design("lin-lee-1999-table-2"),
    "random": design("random-1"),
    "on a linear part": made_up.hierarchy_on_linear(4),
    "on a linear part within a limit": made_up.limited(made_up.hierarchy_on_linear(5), 60.0),
    "scheduling": made_up.scheduling(4),
    "scheduling within a limit": made_up.limited(made_up.scheduling(5), 60.0),
    "resonators": made_up.resonating(made_up.linear("lqi", 2), 1, 3.0, 700.0),
    "resonators within a limit": made_up.limited(
        made_up.resonating(made_up.scheduling(5), 2, 3.0, 700.0), 60.0
    ),
    "silent": silent(),
    "aflc": named_design("jee-koren-2004-aflc"),
    "soflc": named_design("jee-koren-1995-soflc"),
    "soc": named_design("huang-soc"),
    "neural": named_design("huang-neural"),
}
for form in ("P", "PI", "PD"):
    changes = {"form": form, "integral_gain": 0.7, "low_velocity": LOW.model_dump(mode="json")}
    CASES[form] = updated("jee-koren-2004-flc", **changes)
    changes["low_velocity"]["blu_mm"] = 0.02
    CASES[f"{form}, another BLU"] = updated("jee-koren-2004-flc", **changes)
CASES |= {f"fuzzy-sliding {name}": record for name, record in EVERY.items()}


WRITTEN = [name for name in builtin_designs() if named_design(name).kind.law]


def samples(record, count=800):
    """Random signals, then all pairs of edges and centres, their outermost and beyond."""
    rng = np.random.default_rng(11)
    inputs = getattr(record.controller, "inputs", ())
    spans = {"error": 30.0} if record.plant.name == "feed-drive" else {"error": 1.0}
    spans |= {"error_rate": 1.0, "velocity": 0.0}
    spans |= {item.name.removeprefix("previous_"): 1.3 / item.scale for item in inputs}
    spans |= {name: 1.0 for name in record.kind.reads(record.controller) if name not in spans}
    signals = {name: span * rng.uniform(-1.0, 1.0, count) for name, span in spans.items()}
    signals["velocity"] = 400.0 * rng.uniform(-1.0, 1.0, count) ** 3
    rows = [
        dict(zip(signals, row, strict=True)) for row in np.array([*signals.values()]).T.tolist()
    ]
    if inputs:
        marks = [-2.0, -1.1, -1.0, -0.6, -0.2, 0.0, 0.05, 0.2, 0.65, 1.0, 1.5]
        names = [item.name for item in inputs if not item.name.startswith("previous_")]
        scales = {item.name: item.scale for item in inputs}
        for left, right in product(marks, repeat=2):
            row = dict.fromkeys(signals, 0.0)
            for k, name in enumerate(names):
                row[name] = (left, right)[k % 2] / scales[name]
            rows.append(row)
    elif spans["error"] == 30.0:
        marks = [-40.0, -21.0, -16.5, -2.0, -0.5, 0.0, 1.5, 4.5, 7.0, 21.0, 40.0]
        rows += [
            dict.fromkeys(signals, 0.0) | {"error": e}
            for pair in product(marks, repeat=2)
            for e in pair
        ]
    return rows
