"""Designs of two feed drives, with controllers that read both axes."""

from hfc_design.files.design import Design

SILENT = {"kind": "pid", "pid": {"k_p": 0.0, "k_i": 0.0, "k_d": 0.0}}
SPEED, ZONE = 100.0, 0.5
K_P = {"x": 2.0, "y": 3.0}


def of_both(controller, limit=None):
    plant = {"name": "feed-drive", "parameters": {}, "axes": {"x": {}, "y": {}}}
    limits = {"command": limit} if limit else {}
    whole = {"name": "two", "plant": plant, "limits": limits}
    return Design.model_validate(whole | {"controller": {"sample_time_s": 0.01} | controller})


def compensated(limit=None, inner=SILENT, **changes):
    """Beside what is ``inner`` a dynamic compensation."""
    own = {"kind": "dynamic-compensation", "k_p": K_P, "dead_zone": ZONE}
    own |= {"programmed_speed": SPEED, "inner": inner} | changes
    return of_both(own, limit)
