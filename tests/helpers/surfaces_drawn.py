"""Pictures of surfaces as numbers, and designs that have several."""

import json

import numpy as np

from hfc_design import api as hfc
from hfc_design.controllers import surfaces
from hfc_design.files.design import design_json
from hfc_design.report.designs import picture


def drawn(monkeypatch, *asked):
    """What a picture of a surface is made of: column, row, values, labels."""
    found = []
    monkeypatch.setattr(surfaces.units, "surface", lambda *told: found.append(told))
    picture(hfc.load_design(asked[0]), "surface", *asked[1:])
    return found[0]


def around_soc(**axes):
    """Cross-coupled control around self-organising controllers, whose tables differ by axis."""
    record, own = (
        json.loads(design_json(hfc.load_design(name)))
        for name in ("huang-cross-coupled", "huang-soc")
    )
    table = np.subtract.outer(np.arange(11.0), np.arange(11.0))
    inner = {
        axis: own["controller"] | {"table": (size * table).tolist()} for axis, size in axes.items()
    }
    per_axis = {"kind": "per-axis", "axes": inner}
    record["controller"]["inner"] = per_axis if len(inner) > 1 else inner["all"]
    return record | {"name": "around"}
